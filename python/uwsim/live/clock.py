"""Clocks for missions on a live simulator, with which a mission waits while another thread steps the simulator."""

from __future__ import annotations

from uwsim.live.step_loop import StepLoop


class LiveClock:
    """A Clock (uwsim.navigation.control.Clock) for one mission on one thread.

    The simulator does not wait for the mission. A wait is measured from the end of the previous wait, so that a control
    loop keeps its period despite the computation between waits. If the resulting time is already past, the wait is
    measured from now.
    """

    def __init__(self, loop: StepLoop) -> None:
        self._loop = loop
        self._woken_at: int | None = None  # steps_made of the loop when the last wait ended

    def __repr__(self) -> str:
        return f"<{type(self).__name__} at {self.time_s:.3f} s>"

    @property
    def time_s(self) -> float:
        """Simulated time since the start in seconds."""
        return self._loop.sim.time_s

    def wait(self, duration_s: float) -> None:
        """Return when duration_s simulated seconds, rounded to whole steps, have passed.

        While the simulator is paused, the wait continues. Raises ValueError for an invalid duration, NotRunningError if
        the simulator stops, RuntimeError if it is reset, and any error that stops the simulation.
        """
        steps = duration_s / self._loop.sim.step_s
        if not 0 <= steps < 2**53:
            raise ValueError(f"duration_s = {duration_s} s: must be finite and not negative")
        until = self._until(round(steps))
        self._wait_until(until)
        self._woken_at = until

    def _until(self, steps: int) -> int:
        now = self._loop.steps_made
        if self._woken_at is None or self._woken_at + steps < now:
            return now + steps
        return self._woken_at + steps

    def _wait_until(self, until: int) -> None:
        self._loop.alarm(until).wait()


class MissionClock(LiveClock):
    """A LiveClock that pauses the simulator between a mission's waits; see LiveSimulator.mission_clock."""

    def __init__(self, loop: StepLoop) -> None:
        super().__init__(loop)
        self._woken_at = loop.hold(self)

    def _wait_until(self, until: int) -> None:
        self._loop.in_turn(lambda: self._loop.alarm(until, holder=self)).wait()

    def close(self) -> None:
        """Let simulated time pass freely again."""
        self._loop.release(self)
