"""The clock of a mission in flight: steps the simulator, enforces the time limit, and calls back after waits."""

from __future__ import annotations

from collections.abc import Callable

from uwsim.base.wall_timer import Measurement
from uwsim.simulator.simulator import Simulator


class FlightOverError(Exception):
    """Raised to end the flight immediately; the message is the reason."""


class FlightClock:
    """A Clock that steps a simulator.

    Waits are rounded to whole steps, at least one; rounding errors do not accumulate. end_tick: the tick at which the
    flight ends; end_because: the reason to report. on_pause: called after each wait, before the mission continues; may
    raise FlightOverError. physics: measures the wall time of the steps.
    """

    def __init__(
        self, sim: Simulator, end_tick: int, end_because: str, on_pause: Callable[[], None], physics: Measurement
    ) -> None:
        self._sim, self._step_s, self._physics = sim, sim.step_s, physics
        self._end_tick, self.end_because = end_tick, end_because
        self._on_pause = on_pause
        self._start_tick, self._waited_s = sim.tick, 0.0

    @property
    def time_s(self) -> float:
        """Simulated time in seconds."""
        return self._sim.time_s

    def wait(self, duration_s: float) -> None:
        """Let simulated time pass. Raises FlightOverError at the time limit."""
        sim, tick = self._sim, self._sim.tick
        self._waited_s += duration_s
        wake_tick = max(self._start_tick + round(self._waited_s / self._step_s), tick + 1)
        with self._physics:
            sim.step(min(wake_tick, max(self._end_tick, tick)) - tick)
        if sim.tick >= self._end_tick:
            raise FlightOverError(self.end_because)
        self._on_pause()
