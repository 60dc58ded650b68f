"""The clock of a mission that surveys: as simulated time passes, the sonar pings."""

from __future__ import annotations

from collections.abc import Callable

from uwsim.simulator import Simulator
from uwsim.survey.chain import ScanChain
from uwsim.survey.log import SurveyLog


class PingingClock:
    """Pings at a steady rate and sends each ping through the chain.

    on_ping: called after each. on_pause: called when a wait is over, before the mission does anything: what the
    mission will do follows from its state then.
    """

    def __init__(
        self,
        sim: Simulator,
        chain: ScanChain,
        log: SurveyLog,
        ping_interval_s: float,
        on_ping: Callable[[], None],
        on_pause: Callable[[], None],
    ) -> None:
        self._sim = sim
        self._chain = chain
        self._log = log
        self._steps_between_pings = max(1, round(ping_interval_s / sim.step_s))
        self.steps_to_ping = self._steps_between_pings
        self._on_ping = on_ping
        self._on_pause = on_pause

    @property
    def time_s(self) -> float:
        """Simulated seconds since the start."""
        return self._sim.time_s

    def wait(self, duration_s: float) -> None:
        """Let simulated time pass, pinging whenever it is due."""
        steps = round(duration_s / self._sim.step_s)
        while steps > 0:
            now = min(steps, self.steps_to_ping)
            with self._chain.timer.measure("physics"):
                self._sim.step(now)
            steps -= now
            self.steps_to_ping -= now
            if self.steps_to_ping == 0:  # at once, so that the mission's own look is this same ping
                self._ping()
        self._on_pause()

    def _ping(self) -> None:
        self.steps_to_ping = self._steps_between_pings
        rov = self._sim.rov
        with self._chain.timer.measure("rays"):
            ping = rov.sonar.ping()
        points = self._chain.insert(ping.ranges_m, rov.pose.world_from_body, ping.world_from_sonar, self._sim.time_s)
        self._log.note(ping, points)
        self._on_ping()
