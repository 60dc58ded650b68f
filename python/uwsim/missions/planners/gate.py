"""Gate passing by sonar: finds two posts in a level ping, moves to a point in front of them, and passes between them.

A post is a narrow group of neighbouring beams whose echoes are nearer than those on both sides. Two posts whose
separation matches the gate's width are taken as the gate; its position is the median over several pings. The gate is
measured from afar, and again from directly in front of it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from uwsim.base.arguments import require_positive
from uwsim.base.arrays import Floats
from uwsim.missions.moves import goto, hold, turn_to
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.missions.steps import Steps, StoppedError, until_at
from uwsim.navigation.control.protocols import PingLike
from uwsim.navigation.sensor_choice import height_above_bed_m

STAND_OFF_M = 6.0  # in front of and behind the gate
STEPS_OUT_M = 1.0  # a post is nearer than its surroundings by at least this much
WIDEST_POST_M = 0.8
WIDTH_TOLERANCE = 0.2  # fraction of the gate's width
LOOKS, LOOK_PERIOD_S = 8, 0.3
NEAR_M = 8.0  # maximum distance between the gate and its expected position
SEARCH_RAD = math.radians(30.0)  # how far to search on both sides if the gate is not seen ahead


@dataclass(frozen=True, eq=False)
class Gate:
    """A measured gate. middle_m: midpoint between the posts, (2,).

    heading_rad: direction of passage, away from where the gate was seen.
    """

    middle_m: Floats
    heading_rad: float
    width_m: float


def pass_gate(
    vehicle: OwnVehicle,
    near_m: Sequence[float],
    width_m: float,
    height_m: float,
    *,
    speed_m_s: float = 0.4,
) -> Steps[Gate]:
    """Find a gate of known width and height near a position (2,), searching from here, and pass through its middle.

    Logs `gate_seen` for each measurement, and `gate_passed`. Raises StoppedError if the gate is not seen, and
    ValueError for invalid arguments.
    """
    require_positive(width_m=width_m, height_m=height_m)
    place = np.asarray(near_m, np.float64)
    altitude_m = 0.5 * height_m
    sonar = vehicle.sonar
    sonar.aim(0.0)
    yield from goto(vehicle, vehicle.pose.position_world_m[:2], altitude_m=altitude_m, speed_m_s=speed_m_s)
    yield from until_at(sonar, 0.0)
    gate = yield from _found(vehicle, place, width_m, altitude_m)
    for distance_m in (2.0 * STAND_OFF_M, STAND_OFF_M):
        ahead = np.array([math.cos(gate.heading_rad), math.sin(gate.heading_rad)])
        before = gate.middle_m - distance_m * ahead
        if float((np.asarray(vehicle.pose.position_world_m[:2]) - before) @ ahead) > 0.0 and distance_m > STAND_OFF_M:
            continue  # the vehicle is already nearer than that
        yield from goto(vehicle, before, altitude_m=altitude_m, speed_m_s=speed_m_s)
        yield from turn_to(vehicle, gate.heading_rad)
        gate = (yield from _measured(vehicle, gate.middle_m, width_m, altitude_m)) or gate
    ahead = np.array([math.cos(gate.heading_rad), math.sin(gate.heading_rad)])
    behind = gate.middle_m + STAND_OFF_M * ahead
    yield from goto(vehicle, behind, altitude_m=altitude_m, heading_rad=gate.heading_rad, speed_m_s=speed_m_s)
    vehicle.log("gate_passed", middle_m=gate.middle_m.tolist(), heading_deg=math.degrees(gate.heading_rad))
    return gate


def _found(vehicle: OwnVehicle, place: Floats, width_m: float, altitude_m: float) -> Steps[Gate]:
    """Look towards the gate's expected position, then to both sides of it."""
    x, y, _ = vehicle.pose.position_world_m.tolist()
    towards_rad = math.atan2(place[1] - y, place[0] - x)
    for aside_rad in (0.0, SEARCH_RAD, -SEARCH_RAD):
        yield from turn_to(vehicle, towards_rad + aside_rad)
        gate = yield from _measured(vehicle, place, width_m, altitude_m)
        if gate is not None:
            return gate
    raise StoppedError(f"no gate of {width_m:g} m is seen near ({place[0]:.1f}, {place[1]:.1f}) m")


def _measured(vehicle: OwnVehicle, place: Floats, width_m: float, altitude_m: float) -> Steps[Gate | None]:
    """Return the gate's median over several pings from one place, or None if fewer than half of them show it."""
    seen = []
    x, y, z = vehicle.pose.position_world_m.tolist()
    here = (x, y, z - height_above_bed_m(vehicle) + altitude_m)  # the vehicle may still be sinking
    for _ in range(LOOKS):
        yield from hold(vehicle, LOOK_PERIOD_S, position_world_m=here)
        pair = gate_posts(posts(vehicle.sonar.ping()), place, width_m)
        if pair is not None:
            seen.append(pair)
    if 2 * len(seen) < LOOKS:
        return None
    left, right = np.median(np.array(seen), axis=0)
    across = left - right
    heading_rad = math.atan2(-across[0], across[1])  # the left post is to port of the passage
    gate = Gate(0.5 * (left + right), heading_rad, float(np.linalg.norm(across)))
    vehicle.log("gate_seen", middle_m=gate.middle_m.tolist(), width_m=gate.width_m, pings=len(seen))
    return gate


def posts(ping: PingLike) -> Floats:
    """Return the posts (k, 2) in a ping, from starboard to port, in the world frame; see the module docstring."""
    ranges = np.where(np.isfinite(ping.ranges_m), ping.ranges_m, np.inf).astype(np.float64)
    nearer = np.flatnonzero(ranges[:-1] - ranges[1:] > STEPS_OUT_M) + 1  # first beams of groups
    points = np.asarray(ping.points_sonar_m, np.float64)
    found = []
    for first in nearer.tolist():
        last = first
        while last + 1 < len(ranges) and abs(ranges[last + 1] - ranges[last]) <= STEPS_OUT_M:
            last += 1
        width_m = float(np.linalg.norm(points[last] - points[first]))
        if last + 1 < len(ranges) and ranges[last + 1] > ranges[last] and width_m <= WIDEST_POST_M:
            middle = points[first : last + 1].mean(axis=0)
            found.append(ping.world_from_sonar[:2, :3] @ middle + ping.world_from_sonar[:2, 3])
    return np.array(found).reshape(-1, 2)


def gate_posts(found: Floats, place: Floats, width_m: float) -> Floats | None:
    """Return the two posts, port first, of the gate of this width nearest to a place, or None if there is no match."""
    pairs = [
        np.array([port, starboard])
        for starboard, port in combinations(found, 2)
        if abs(float(np.linalg.norm(port - starboard)) - width_m) <= WIDTH_TOLERANCE * width_m
    ]

    def off_m(pair: Floats) -> float:
        return float(np.linalg.norm(pair.mean(axis=0) - place))

    best = min(pairs, key=off_m, default=None)
    return best if best is not None and off_m(best) <= NEAR_M else None
