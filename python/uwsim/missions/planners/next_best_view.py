"""Next-best-view exploration: always go where a view shows the most unknown water for its distance.

After Connolly, "The determination of next best views", ICRA 1985, and Gonzalez-Banos and Latombe, "Navigation
strategies for exploring indoor environments", IJRR 2002, whose gain over distance decays exponentially. Views are free
places near the frontiers of the live map; ways lead through water that the map knows to be free, so caves can be
entered, which planners that work by columns take for closed.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uwsim.mapping import DistanceField, frontiers
from uwsim.mapping.ranging import transform_points
from uwsim.missions.moves import require_able, turn_to
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.missions.planners.cells import Cells
from uwsim.missions.planners.live_map import LiveMap
from uwsim.missions.planners.map_way import go_by_map
from uwsim.missions.steps import Steps, StoppedError, aim_to, race, wait

RESOLUTION_M, PING_PERIOD_S, CLEARANCE_M = 0.4, 0.25, 1.2
VIEW_RANGE_M, HIGH_DEG, VIEWS, DECAY_PER_M = 10.0, 25, 40, 0.05  # higher views would count the air
ELEVATIONS_RAD = (math.radians(-35.0), math.radians(5.0))  # of the sonar: at the bed and ahead, and at the roof
LEAST_GAIN_M3 = 8.0
SEEN_M = 4.0  # around earlier views, whose unknown rest lies behind the bed or outside


def next_best_view(
    vehicle: OwnVehicle, bound_m: float = 24.0, deepest_m: float = 9.0, most_views: int = 12
) -> Steps[int]:
    """Explore water within bound_m of the start, roofed or not; return the number of views taken.

    Logs `view` with the gain [m^3] expected of each. Ends when no view promises 8 m^3 or can be reached.
    """
    if not vehicle.released:
        vehicle.undock()
    start = np.array(vehicle.pose.position_world_m, np.float64)
    low, high = start - bound_m, start + bound_m
    low[2], high[2] = -deepest_m, 0.0
    live = LiveMap(vehicle, RESOLUTION_M, Cells((float(start[0]), float(start[1])), 0.0, 2.0))
    rng = np.random.default_rng(0)  # candidates only: the same flight for the same echoes
    views = [start]
    yield from race(_look_round(vehicle), _map(vehicle, live))
    for taken in range(1, most_views + 1):
        candidates = _candidates(live, low, high, rng)
        gains = _gains_m3(live, candidates)
        away_m = np.linalg.norm(candidates - np.asarray(vehicle.pose.position_world_m), axis=1)
        seen_m = np.linalg.norm(candidates[:, None] - np.array(views), axis=2).min(axis=1)
        worth = gains * np.exp(-DECAY_PER_M * away_m) * (1.0 - np.exp(-((seen_m / SEEN_M) ** 2)))
        for k in np.argsort(-worth, kind="stable")[: int((gains >= LEAST_GAIN_M3).sum())]:
            views.append(candidates[k])
            try:
                yield from race(_view(vehicle, live, candidates[k]), _map(vehicle, live))
                break
            except StoppedError:
                require_able(vehicle)  # else no free way leads there, or the vehicle cannot turn there
        else:
            return taken
        vehicle.log("view", gain_m3=float(gains[k]), position_m=candidates[k].tolist())
    return most_views + 1


def _view(vehicle: OwnVehicle, live: LiveMap, goal: NDArray[np.float64]) -> Steps[None]:
    yield from go_by_map(vehicle, live.map, goal, clearance_m=CLEARANCE_M)
    yield from _look_round(vehicle)


def _look_round(vehicle: OwnVehicle) -> Steps[None]:
    """Turn once on the spot with the sonar down, and back with it up."""
    yaw_rad = vehicle.pose.yaw_rad
    for elevation_rad, sign in zip(ELEVATIONS_RAD, (1.0, -1.0), strict=True):
        yield from aim_to(vehicle.sonar, elevation_rad)
        for eighth in range(1, 9):
            yield from turn_to(vehicle, yaw_rad + sign * eighth * 0.25 * math.pi, within_rad=0.2)


def _map(vehicle: OwnVehicle, live: LiveMap) -> Steps[None]:
    """Insert pings into the map, without end."""
    while True:
        ping = vehicle.sonar.ping()
        echoes = np.asarray(ping.points_sonar_m)[np.isfinite(ping.ranges_m)]
        if len(echoes):
            live.add(ping, transform_points(echoes, ping.world_from_sonar).astype(np.float64))
        yield wait(PING_PERIOD_S)


def _candidates(
    live: LiveMap, low: NDArray[np.float64], high: NDArray[np.float64], rng: np.random.Generator
) -> NDArray[np.float64]:
    """Return places (n, 3) near the frontiers, in known free water with clearance."""
    edges = [each.voxels_world_m for each in frontiers(live.map, low, high, voxels_min=20)]
    if not edges:
        return np.empty((0, 3))
    field = DistanceField(live.map, low, high, max_distance_m=4.0)
    voxels = np.concatenate(edges)
    near = voxels[rng.integers(len(voxels), size=2000)] + rng.uniform([-3, -3, -1], [3, 3, 1], (2000, 3))
    near = near[((near > low) & (near < high)).all(axis=1) & (near[:, 2] < -1.0)]
    near = near[np.nan_to_num(field.distance_m(near)) > CLEARANCE_M]
    return np.asarray(near[live.map.state_at(near) == 0][:VIEWS])


def _gains_m3(live: LiveMap, places: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the unknown volume that a turn on the spot would show from each place, (n,)."""
    if not len(places):
        return np.empty(0)
    half = np.sqrt(0.5)
    turns = np.array([[0, 0, 0, 1], [0, 0, half, half], [0, 0, 1, 0], [0, 0, -half, half]], np.float64)
    where, facing = np.repeat(places, 4, axis=0), np.tile(turns, (len(places), 1))
    seen = live.map.unknown_in_view_m3(where, facing, 90, HIGH_DEG, VIEW_RANGE_M)
    return np.asarray(seen.reshape(-1, 4).sum(axis=1))
