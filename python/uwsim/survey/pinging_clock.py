"""The clock of a surveying mission: the sonar pings as simulated time passes."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.control.protocols import EstimateLike
from uwsim.simulator import Simulator
from uwsim.survey.ping_log import PingLog
from uwsim.survey.ping_to_map import PingToMap
from uwsim.survey.wall_time import MISSION

TakePing = Callable[[_core.Ping, _core.Telemetry, NDArray[np.float64]], object]


class PingingClock:
    """Pings at a fixed rate and passes each ping through the chain to the map.

    on_ping: called after each ping. on_pause: called at the end of each wait, before the mission continues; at that
    moment everything that the mission will do depends only on its saved state. on_taken: called with each ping, the
    panel and world_from_body (4, 4) as the map was told it. estimate: where the map is told that the vehicle is; by
    default where it is.
    """

    def __init__(
        self,
        sim: Simulator,
        chain: PingToMap,
        log: PingLog,
        ping_interval_s: float,
        on_ping: Callable[[], None],
        on_pause: Callable[[], None],
        on_taken: TakePing | None = None,
        estimate: EstimateLike | None = None,
    ) -> None:
        self._sim = sim
        self._estimate = estimate
        self._woken_s: float | None = None  # wall time at which the mission went on
        self._chain = chain
        self._physics, self._rays = chain.timer.measure("physics"), chain.timer.measure("rays")
        self._log = log
        self._steps_between_pings = max(1, round(ping_interval_s / sim.step_s))
        self.steps_to_ping = self._steps_between_pings
        self._on_ping = on_ping
        self._on_pause = on_pause
        self._on_taken = on_taken

    @property
    def time_s(self) -> float:
        """Simulated seconds since the start."""
        return self._sim.time_s

    def wait(self, duration_s: float) -> None:
        """Let simulated time pass, and ping whenever a ping is due."""
        if self._woken_s is not None:
            self._chain.timer.add(MISSION, time.perf_counter() - self._woken_s)
        steps = round(duration_s / self._sim.step_s)
        while steps > 0:
            steps_now = min(steps, self.steps_to_ping)
            with self._physics:
                self._sim.step(steps_now)
            steps -= steps_now
            self.steps_to_ping -= steps_now
            if self.steps_to_ping == 0:  # ping now, so that the mission, if it pings at this time, gets the same sample
                self._ping()
        self._on_pause()
        self._woken_s = time.perf_counter()

    def _ping(self) -> None:
        self.steps_to_ping = self._steps_between_pings
        rov = self._sim.rov
        with self._rays:
            ping = rov.sonar.ping()
        body, panel, sonar, mapped_from_m = rov.pose.world_from_body, rov.telemetry(), ping.world_from_sonar, None
        if self._estimate is not None:
            estimated = self._estimate.pose.world_from_body
            sonar, body = estimated @ np.linalg.inv(body) @ sonar, estimated
            mapped_from_m = sonar[:3, 3]
        deviation_m = ping.deviation_m if isinstance(ping, _core.PhysicsPing) else None
        points = self._chain.insert(ping.ranges_m, body, sonar, self._sim.time_s, deviation_m)
        self._log.add(ping, points, panel, mapped_from_m)
        if self._on_taken is not None:
            self._on_taken(ping, panel, body)
        self._on_ping()
