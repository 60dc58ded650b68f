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
from uwsim.survey.ping_to_map import PingToMap
from uwsim.survey.record import SurveyRecord
from uwsim.vehicle import Vehicle

Array = NDArray[np.float64]


class PingKeeper:
    """Keeps a vehicle's pings with the estimated poses that they were mapped by. track: what was kept.

    vehicle: by default the simulator's first.
    """

    def __init__(self, sim: Simulator, vehicle: Vehicle | None = None) -> None:
        self._vehicle = sim.rov if vehicle is None else vehicle
        if not self._vehicle.sensors:
            raise ScenarioError(f"vehicle '{self._vehicle.name}': has no sensors to navigate by")
        self._sim = sim
        self.track = PingTrack()

    def __call__(self, ping: _core.Ping, panel: _core.Telemetry, world_from_body: Array) -> None:
        """Keep one ping: a TakePing of fly_survey."""
        self.keep(ping, world_from_body)

    def keep(self, ping: _core.Ping, world_from_body: Array) -> None:
        """Keep one ping of now."""
        body_from_sonar = np.linalg.inv(self._vehicle.pose.world_from_body) @ ping.world_from_sonar
        std_m = float(np.sqrt(np.mean(self._vehicle.estimate.position_std_m[:2] ** 2)))
        deviation_m = ping.deviation_m if isinstance(ping, _core.PhysicsPing) else None
        points = np.where(ping.valid[:, None], ping.points_sonar_m, np.nan)
        self.track.add(self._sim.time_s, world_from_body, body_from_sonar, ping.ranges_m, points, std_m, deviation_m)


def insert_closed(chain: PingToMap, track: PingTrack, closed: ClosedTrack) -> Array:
    """Pass all pings on, each from where it belongs; return the sonar's positions (n, 3)."""
    sonar_m = np.empty((len(track), 3))
    for k, body in enumerate(closed.world_from_body):
        sonar = body @ track.body_from_sonar[k]
        sonar_m[k] = sonar[:3, 3]
        chain.insert(track.ranges_m[k], body, sonar, track.times_s[k], track.deviation_m[k])
    return sonar_m


def remake(
    sim: Simulator, track: PingTrack, drifted: OccupancyMap, record: SurveyRecord
) -> tuple[OccupancyMap, SurveyRecord, ClosedTrack]:
    """Return the map and the record of a survey as they are when its loops are closed, and the closed track.

    drifted: the map as flown, whose resolution and engine the new one has.
    """
    closed = close_loops(track)
    occupancy = OccupancyMap(resolution_m=drifted.resolution_m, engine=drifted.engine)
    with chain_of(sim, occupancy, bool(record.outlier_filter)) as chain:
        sonar_m = insert_closed(chain, track, closed)
    error_m = np.linalg.norm(sonar_m - record.path_world_m, axis=1)
    return occupancy, replace(record, position_error_m=error_m), closed
