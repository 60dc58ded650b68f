"""The clock of a mission in flight: it steps the simulator, ends the flight at its time, and lets others look in."""

from __future__ import annotations

from collections.abc import Callable

from uwsim.simulator import Simulator


class FlightOverError(Exception):
    """The flight ends here, whatever the mission would do next; the message says why."""


class FlightClock:
    """Steps a simulator.

    Waits are rounded to whole steps, at least one; the rounding does not add up. end_tick: where the flight is over,
    and end_because why. on_pause: called after each wait, before the mission goes on; may raise FlightOverError.
    """

    def __init__(self, sim: Simulator, end_tick: int, end_because: str, on_pause: Callable[[], None]) -> None:
        self._sim = sim
        self._end_tick, self._end_because = end_tick, end_because
        self._on_pause = on_pause
        self._start_tick, self._asked_s = sim.tick, 0.0

    @property
    def time_s(self) -> float:
        """Simulated seconds."""
        return self._sim.time_s

    def wait(self, duration_s: float) -> None:
        """Let simulated time pass. Raises FlightOverError."""
        sim = self._sim
        self._asked_s += duration_s
        wake_tick = max(self._start_tick + round(self._asked_s / sim.step_s), sim.tick + 1)
        sim.step(min(wake_tick, max(self._end_tick, sim.tick)) - sim.tick)
        if sim.tick >= self._end_tick:
            raise FlightOverError(self._end_because)
        self._on_pause()
