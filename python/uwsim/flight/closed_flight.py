"""Corrects tracks by loop closure after a flight, and rebuilds the map from them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.flight.record import ClosedPath, FlightRecord
from uwsim.flight.vehicle_chain import chain_of
from uwsim.mapping import OccupancyMap
from uwsim.mapping.closure import ClosedTrack, PingTrack, close_loops
from uwsim.mapping.map_filler import MapFiller
from uwsim.mapping.ping_to_map import PingToMap
from uwsim.mapping.ranging import place_deviation_m
from uwsim.scenario import ScenarioError
from uwsim.simulator.simulator import Simulator
from uwsim.simulator.vehicle import Vehicle

Array = NDArray[np.float64]


class PingKeeper:
    """Stores a vehicle's pings with the estimated poses used for mapping; can be used as a TakePing.

    track: the stored pings. true_path_m: the vehicle's true position at each ping. vehicle: the vehicle; by default,
    the first in the simulator.
    """

    def __init__(self, sim: Simulator, vehicle: Vehicle | None = None) -> None:
        self._vehicle = sim.rov if vehicle is None else vehicle
        if not self._vehicle.sensors:
            raise ScenarioError(f"vehicle '{self._vehicle.name}': has no sensors to navigate by")
        self._sim = sim
        self.track = PingTrack()
        self.true_path_m: list[Array] = []

    def __call__(self, ping: _core.Ping, panel: _core.Telemetry, world_from_body: Array) -> None:
        """Store a ping taken at the current tick."""
        true_body = self._vehicle.pose.world_from_body
        body_from_sonar = np.linalg.inv(true_body) @ ping.world_from_sonar
        std_m = float(np.sqrt(np.mean(self._vehicle.navigation.shown.position_std_m[:2] ** 2)))
        deviation_m = place_deviation_m(ping)
        points = np.where(ping.valid[:, None], ping.points_sonar_m, np.nan)
        self.track.add(self._sim.time_s, world_from_body, body_from_sonar, ping.ranges_m, points, std_m, deviation_m)
        self.true_path_m.append(true_body[:3, 3])


def closed_flight(
    flown: FlightRecord, sim: Simulator, tracks: Mapping[str, PingTrack], true_paths_m: Mapping[str, Array]
) -> FlightRecord:
    """Return the record with each vehicle's track corrected by loop closure, and the map rebuilt from those tracks.

    true_paths_m: true positions (n, 3) at the pings, by vehicle, used to evaluate the tracks.
    """
    assert flown.occupancy is not None
    occupancy = OccupancyMap(resolution_m=flown.occupancy.resolution_m, engine=flown.occupancy.engine)
    pings_m, paths = {}, {}
    for name, track in tracks.items():
        closed = close_loops(track)
        with MapFiller(occupancy, sim.vehicles[name].sonar.model.range_max_m, threads=sim.threads) as filler:
            pings_m[name] = _insert_closed(chain_of(sim, name, filler, flown.outlier_filter), track, closed)
        path_m = np.array([body[:3, 3] for body in closed.world_from_body]).reshape(-1, 3)
        errors_m = np.linalg.norm(path_m - true_paths_m[name], axis=1)
        matched = len(closed.matches)
        paths[name] = ClosedPath(np.array(track.times_s), path_m, errors_m, len(closed.submaps), matched, closed.tried)
    return replace(flown, occupancy=occupancy, pings_world_m=pings_m, closed=paths)


def _insert_closed(chain: PingToMap, track: PingTrack, closed: ClosedTrack) -> Array:
    """Insert all pings at their corrected poses; return the sonar positions (n, 3)."""
    sonar_m = np.empty((len(track), 3))
    for k, body in enumerate(closed.world_from_body):
        sonar = body @ track.body_from_sonar[k]
        sonar_m[k] = sonar[:3, 3]
        chain.insert(track.ranges_m[k], body, sonar, track.times_s[k], track.deviation_m[k])
    return sonar_m
