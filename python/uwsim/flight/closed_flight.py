"""The map of a flight made anew from the tracks that loop closure has bent, and these tracks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from uwsim.closure import PingTrack, close_loops
from uwsim.flight.map_maker import chain_of
from uwsim.flight.record import FlightRecord
from uwsim.mapping import OccupancyMap
from uwsim.simulator import Simulator
from uwsim.survey.closed_map import insert_closed

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class ClosedPath:
    """A vehicle's track with its loops closed.

    times_s: (n,), of its pings; path_world_m: (n, 3), where it was then; errors_m: (n,), its distance from the truth.
    matched, tried: of the overlaps of its submaps.
    """

    times_s: Array
    path_world_m: Array
    errors_m: Array
    submaps: int
    matched: int
    tried: int

    def __repr__(self) -> str:
        return f"<ClosedPath: {len(self.times_s)} pings, {self.matched} of {self.tried} overlaps matched>"


def closed_flight(
    flown: FlightRecord, sim: Simulator, tracks: Mapping[str, PingTrack], true_paths_m: Mapping[str, Array]
) -> FlightRecord:
    """Return the record with each vehicle's loops closed, and the map made again from the closed tracks.

    true_paths_m: (n, 3) true positions at the pings, by vehicle, to judge the tracks by.
    """
    assert flown.occupancy is not None
    occupancy = OccupancyMap(resolution_m=flown.occupancy.resolution_m, engine=flown.occupancy.engine)
    pings_m, paths = {}, {}
    for name, track in tracks.items():
        closed = close_loops(track)
        with chain_of(sim, name, occupancy, sim.threads) as chain:
            pings_m[name] = insert_closed(chain, track, closed)
        path_m = np.array([body[:3, 3] for body in closed.world_from_body]).reshape(-1, 3)
        errors_m = np.linalg.norm(path_m - true_paths_m[name], axis=1)
        matched = len(closed.matches)
        paths[name] = ClosedPath(np.array(track.times_s), path_m, errors_m, len(closed.submaps), matched, closed.tried)
    return replace(flown, occupancy=occupancy, pings_world_m=pings_m, closed=paths)
