"""Clocks for missions with a remote vehicle: simulated time from /clock, wall time, or lockstep."""

from __future__ import annotations

import math
import time

from uwsim.bridges.remote.connection import RemoteConnection
from uwsim.bridges.remote.frames import seconds

CLOCK = "clock"
STEP_S = 0.005  # for simulators that do not report their step
BEACON_S = 0.02  # between successive odometry messages
PATIENCE_S = 20.0
MOST_STEPS = 100  # of one call, which a slow machine answers in time, too


class RemoteClock:
    """Simulated time from /clock or, without such a topic, the wall time since the clock was created.

    A wait is measured from the time at which the previous wait was due, unless the result is already past, so that a
    control loop keeps its period.
    """

    def __init__(self, connection: RemoteConnection) -> None:
        self._connection = connection
        self._has_clock = CLOCK in connection.topics
        self._wall_start_s = time.monotonic()
        if self._has_clock:
            connection.newest(CLOCK)
        self._woken_s = self.time_s

    @property
    def time_s(self) -> float:
        """The time in seconds."""
        if not self._has_clock:
            return time.monotonic() - self._wall_start_s
        return seconds(self._connection.newest(CLOCK).clock)

    def wait(self, duration_s: float) -> None:
        """Wait for the duration, and for as long as the simulation stays paused. Raises OSError."""
        now_s = self.time_s
        due_s = self._woken_s + duration_s
        if due_s < now_s:
            due_s = now_s + duration_s
        if self._has_clock:
            self._connection.wait_for(lambda: self.time_s >= due_s - 1e-9, None, "")
        else:
            time.sleep(max(due_s - now_s, 0.0))
            self._connection.wait_for(lambda: True, None, "")
        self._woken_s = due_s


class LockstepClock:
    """Pauses a remote simulator and steps it only while the mission waits. `close` resumes the simulator.

    beacon: a topic with period BEACON_S, such as "odom". A wait ends when the latest message on this topic has the new
    time.
    """

    def __init__(self, connection: RemoteConnection, beacon: str) -> None:
        if CLOCK not in connection.topics:
            raise ValueError(f"{connection.url}: --lockstep: there is no /clock: it is not a simulator")
        self._connection, self._beacon = connection, beacon
        pace = connection.call("simulation/pace")
        self._was_paused, self._step_s = bool(pace.get("paused")), float(pace.get("step_s", STEP_S))
        connection.call("simulation/pause")
        connection.newest(beacon)
        self._start_s, self._asked_s, self._steps = seconds(connection.newest(CLOCK).clock), 0.0, 0

    @property
    def time_s(self) -> float:
        """The simulated time in seconds."""
        return self._start_s + self._steps * self._step_s

    def wait(self, duration_s: float) -> None:
        """Step the simulator for a duration, rounded to at least one whole step. Raises OSError."""
        self._asked_s += duration_s
        steps = max(1, round(self._asked_s / self._step_s) - self._steps)
        for begun in range(0, steps, MOST_STEPS):
            self._connection.call("simulation/step", steps=min(MOST_STEPS, steps - begun))
        self._steps += steps
        beacon_s = BEACON_S * math.floor(self.time_s / BEACON_S + 1e-6)
        self._connection.wait_for(
            lambda: seconds(self._connection.newest(self._beacon).header.stamp) >= beacon_s - 1e-6,
            PATIENCE_S,
            f"nothing on topic '{self._beacon}'",
        )

    def close(self) -> None:
        """Resume the simulator, unless it was paused before."""
        if not self._was_paused and not self._connection.lost:
            self._connection.call("simulation/resume")
