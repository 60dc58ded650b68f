"""The map of a survey made anew from the track that loop closure has bent."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.closure import ClosedTrack, PingTrack, close_loops
from uwsim.mapping import OccupancyMap
from uwsim.scenario import ScenarioError
from uwsim.simulator import Simulator
from uwsim.survey.fly import chain_of
from uwsim.survey.record import SurveyRecord

Array = NDArray[np.float64]


class PingKeeper:
    """Keeps a survey's pings with the estimated poses that they were mapped by: a TakePing of fly_survey."""

    def __init__(self, sim: Simulator) -> None:
        if not sim.rov.sensors:
            raise ScenarioError(f"vehicle '{sim.rov.name}': has no sensors to navigate by")
        self._sim = sim
        self.track = PingTrack()

    def __call__(self, ping: _core.Ping, panel: _core.Telemetry, world_from_body: Array) -> None:
        """Keep one ping."""
        body_from_sonar = np.linalg.inv(self._sim.rov.pose.world_from_body) @ ping.world_from_sonar
        std_m = float(np.sqrt(np.mean(self._sim.rov.estimate.position_std_m[:2] ** 2)))
        deviation_m = ping.deviation_m if isinstance(ping, _core.PhysicsPing) else None
        points = np.where(ping.valid[:, None], ping.points_sonar_m, np.nan)
        self.track.add(self._sim.time_s, world_from_body, body_from_sonar, ping.ranges_m, points, std_m, deviation_m)


def remake(
    sim: Simulator, track: PingTrack, drifted: OccupancyMap, record: SurveyRecord
) -> tuple[OccupancyMap, SurveyRecord, ClosedTrack]:
    """Return the map and the record of a survey as they are when its loops are closed, and the closed track.

    drifted: the map as flown, whose resolution and engine the new one has.
    """
    closed = close_loops(track)
    occupancy = OccupancyMap(resolution_m=drifted.resolution_m, engine=drifted.engine)
    sonar_m = np.empty((len(track), 3))
    with chain_of(sim, occupancy, bool(record.outlier_filter)) as chain:
        for k, body in enumerate(closed.world_from_body):
            sonar = body @ track.body_from_sonar[k]
            sonar_m[k] = sonar[:3, 3]
            chain.insert(track.ranges_m[k], body, sonar, track.times_s[k], track.deviation_m[k])
    error_m = np.linalg.norm(sonar_m - record.path_world_m, axis=1)
    return occupancy, replace(record, position_error_m=error_m), closed
