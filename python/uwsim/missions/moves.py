"""Steps that move a vehicle: goto, hold, turn_to, dive_to, follow. All steer by the vehicle's estimated pose.

They do not avoid obstacles: the path must be clear. They raise StoppedError if the vehicle is stuck, its battery is
empty or it has capsized. Positions are in the world frame (ENU, z up).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arguments import require_positive
from uwsim.missions.own_vehicle import OwnVehicle, own_vehicle
from uwsim.missions.steps import Steps, StoppedError, wait
from uwsim.missions.vehicle import Vehicle
from uwsim.navigation.control.autopilot import Autopilot, wrap_angle
from uwsim.navigation.control.controller import Controller
from uwsim.navigation.sensor_choice import altimeter

Point = Sequence[float] | NDArray[Any]
GRACE_S = 60.0  # added to a move's time limit, which is otherwise three times its nominal duration
SPEED_MAX_M_S = 10.0  # of any vehicle
SLOWEST_M_S, SLOW_DOWN_PER_S = 0.1, 0.4  # speed near the end: SLOWEST + SLOW_DOWN x distance
REACHED_M, REACHED_IN_PASSING_M = 0.1, 0.5
"""Distances at which a target counts as reached: by a vehicle that can stand still there, and by one that cannot."""
FACE_FROM_M = 1.0  # the vehicle faces the direction of travel while farther than this from its target
TURN_FIRST_RAD = math.radians(45.0)
BACK_PER_S = 0.5  # speed back to a point or a line, per metre of offset
CAPSIZED_COSINE = 0.3  # cosine of the tilt from upright below which the vehicle counts as capsized
DRAUGHT_MAX_M, STILL_M, STILL_S = 1.0, 0.02, 5.0
"""The greatest depth at which the origin of a vehicle floats, assumed; how little it rises then, and for how long."""
CLIMB_M = 1.0  # limit on the height error used for steering: fast dives underway make slender vehicles pitch over


def goto(
    vehicle: Vehicle,
    position_world_m: Point,
    *,
    altitude_m: float | None = None,
    heading_rad: float | None = None,
    speed_m_s: float = 0.5,
    within_m: float | None = None,
) -> Steps[None]:
    """Move straight to a position (3,), or (2,) with altitude_m above the bed, until it is reached.

    heading_rad: heading to hold on the way; defaults to the direction of travel. within_m: the distance at which the
    position counts as reached; by default 0.1 m, or 0.5 m for a vehicle without thrust ahead and aside, which cannot
    stand still. The vehicle then keeps its last efforts; `hold` keeps it at the position.
    """
    vehicle = own_vehicle(vehicle)
    within_m = reached_m(vehicle) if within_m is None else within_m
    x, y, height = _target(vehicle, "goto", position_world_m, altitude_m)
    require_positive("goto", speed_m_s=speed_m_s, within_m=within_m)
    require_speed("goto", speed_m_s)
    start = vehicle.pose
    start_x, start_y, start_z = start.position_world_m.tolist()
    whole_m = math.hypot(x - start_x, y - start_y)
    facing = start.yaw_rad
    deadline_s = vehicle.time_s + GRACE_S + 3.0 * math.hypot(whole_m, height() - start_z) / speed_m_s
    while True:
        at_x, at_y, at_z = vehicle.pose.position_world_m.tolist()
        left_m, z_m = math.hypot(x - at_x, y - at_y), height()
        if math.hypot(left_m, z_m - at_z) <= within_m:
            return
        if vehicle.time_s > deadline_s:
            raise StoppedError(f"stuck {math.hypot(left_m, z_m - at_z):.1f} m before ({x:.1f}, {y:.1f}, {z_m:.1f}) m")
        if left_m > FACE_FROM_M:
            facing = math.atan2(y - at_y, x - at_x)
        heading = facing if heading_rad is None else heading_rad
        speed = min(speed_m_s, SLOWEST_M_S + SLOW_DOWN_PER_S * left_m)
        if heading_rad is None and abs(wrap_angle(heading - vehicle.pose.yaw_rad)) > TURN_FIRST_RAD:
            speed = 0.0
        is_upright = min(left_m, whole_m) <= REACHED_IN_PASSING_M  # a drift of centimetres is no part of the way
        share = 0.0 if altitude_m is not None or is_upright else min(left_m / whole_m, 1.0)
        ahead = min(speed, BACK_PER_S * left_m) / max(left_m, 1e-9)
        velocity = (ahead * (x - at_x), ahead * (y - at_y))
        yield from steer(vehicle, heading, velocity, z_m + share * (start_z - z_m))


def can_stand(vehicle: Vehicle) -> bool:
    """Return whether the vehicle can keep a place whatever its heading: it has thrust ahead and aside."""
    return own_vehicle(vehicle).controllable >= {"surge", "sway"}


def reached_m(vehicle: Vehicle, within_m: float = REACHED_M) -> float:
    """Return the distance at which a target counts as reached: within_m, or more for a vehicle that cannot stand."""
    return within_m if can_stand(vehicle) else max(within_m, REACHED_IN_PASSING_M)


def hold(
    vehicle: Vehicle,
    duration_s: float = math.inf,
    *,
    position_world_m: Point | None = None,
    heading_rad: float | None = None,
) -> Steps[None]:
    """Hold a position (3,) and heading (default: the current ones) for duration_s (default: forever).

    A hold that directly follows another keeps the same position, so that repeated holds do not drift.
    """
    vehicle = own_vehicle(vehicle)
    if not duration_s > 0.0:
        raise ValueError(f"hold: duration_s = {duration_s} s: must be positive")
    pose, before = vehicle.pose, vehicle.held()
    here, facing = (pose.position_world_m, pose.yaw_rad) if before is None else before
    x, y, height = _target(vehicle, "hold", here if position_world_m is None else position_world_m)
    heading = facing if heading_rad is None else heading_rad
    end_s = vehicle.time_s + duration_s - 1e-6
    autopilot = vehicle.autopilot
    while vehicle.time_s < end_s:
        if isinstance(autopilot, Controller):
            require_able(vehicle)
            autopilot.hold((x, y, height()), heading)
            yield wait(autopilot.period_s)
        else:
            yield from steer(vehicle, heading, _back_to(vehicle, x, y), height())
        vehicle.note_held((np.array([x, y, height()]), heading))


def turn_to(vehicle: Vehicle, heading_rad: float, *, within_rad: float = math.radians(3.0)) -> Steps[None]:
    """Turn on the spot to a heading, measured counterclockwise from east."""
    vehicle = own_vehicle(vehicle)
    require_positive("turn_to", within_rad=within_rad)
    _require_finite("turn_to", heading_rad=heading_rad)
    x, y, z = vehicle.pose.position_world_m.tolist()
    deadline_s = vehicle.time_s + GRACE_S
    while abs(left_rad := wrap_angle(heading_rad - vehicle.pose.yaw_rad)) > within_rad:
        if vehicle.time_s > deadline_s:
            raise StoppedError(f"stuck in a turn, {abs(math.degrees(left_rad)):.0f} degrees before its end")
        yield from steer(vehicle, heading_rad, _back_to(vehicle, x, y), z)


def dive_to(vehicle: Vehicle, depth_m: float, *, within_m: float = 0.2) -> Steps[None]:
    """Dive or climb on the spot to a depth (positive down), of at least 0 m and above the bed."""
    vehicle = own_vehicle(vehicle)
    require_positive("dive_to", within_m=within_m)
    _require_finite("dive_to", depth_m=depth_m)
    pose = vehicle.pose
    x, y, z = pose.position_world_m.tolist()
    if depth_m < 0.0:
        raise ValueError(f"dive_to: depth_m = {depth_m:g} m: must be at least 0 m, the mean water surface")
    is_over_terrain = vehicle.beyond_terrain(x, y, z) is None
    if depth_m > -z and is_over_terrain and (bed := vehicle.beyond_terrain(x, y, -depth_m)) is not None:
        raise ValueError(f"dive_to: depth_m = {depth_m:g} m: must be above the terrain, {bed}")
    heading, deadline_s = pose.yaw_rad, vehicle.time_s + GRACE_S + abs(depth_m + z) / 0.1
    while abs(left_m := depth_m + float(vehicle.pose.position_world_m[2])) > within_m:
        if vehicle.time_s > deadline_s:
            raise StoppedError(f"stuck {abs(left_m):.1f} m from a depth of {depth_m:g} m")
        yield from steer(vehicle, heading, _back_to(vehicle, x, y), -depth_m)


def surface(vehicle: Vehicle, *, within_m: float = 0.2) -> Steps[None]:
    """Rise on the spot to within_m of the mean water surface, or as high as the vehicle gets.

    A hull that emerges loses buoyancy, which its thrust may not replace: it floats by its draught below the surface.
    The rise therefore also ends, with the event `at_surface`, once the vehicle is at most 1 m deep and has not risen by
    2 cm for 5 s.
    """
    vehicle = own_vehicle(vehicle)
    highest_m, risen_s = -math.inf, vehicle.time_s
    for pause in dive_to(vehicle, 0.0, within_m=within_m):
        yield pause
        z_m = float(vehicle.pose.position_world_m[2])
        if z_m > highest_m + STILL_M:
            highest_m, risen_s = z_m, vehicle.time_s
        elif z_m >= -DRAUGHT_MAX_M and vehicle.time_s - risen_s >= STILL_S:
            vehicle.log("at_surface", depth_m=round(-z_m, 2))
            return


def follow(
    vehicle: Vehicle,
    path_world_m: Sequence[Point] | NDArray[Any],
    *,
    altitude_m: float | None = None,
    speed_m_s: float = 0.5,
) -> Steps[None]:
    """Follow straight legs through points (n, 3), or (n, 2) with altitude_m above the bed, beginning at the first."""
    require_positive("follow", speed_m_s=speed_m_s)
    require_speed("follow", speed_m_s)
    points = np.asarray(path_world_m, np.float64)
    if points.ndim != 2 or len(points) < 2:
        raise ValueError(f"follow: path_world_m.shape = {points.shape}: must be (n, 3) or (n, 2), n at least 2")
    vehicle = own_vehicle(vehicle)
    for point in points:
        _target(vehicle, "follow", point, altitude_m)  # refuses a bad point before the first leg is flown
    yield from goto(vehicle, points[0], altitude_m=altitude_m, speed_m_s=speed_m_s, within_m=REACHED_IN_PASSING_M)
    for start, end in pairwise(points):
        yield from follow_leg(vehicle, start, end, altitude_m=altitude_m, speed_m_s=speed_m_s)


def follow_leg(
    vehicle: OwnVehicle,
    start: NDArray[Any],
    end: NDArray[Any],
    *,
    altitude_m: float | None = None,
    speed_m_s: float = 0.5,
) -> Steps[None]:
    """Follow one leg, staying on the line between its ends."""
    x, y, height = _target(vehicle, "follow", end, altitude_m)
    start_x, start_y = float(start[0]), float(start[1])
    length_m = math.hypot(x - start_x, y - start_y)
    if length_m < 1e-3:
        yield from goto(vehicle, end, altitude_m=altitude_m, speed_m_s=speed_m_s)
        return
    east, north = (x - start_x) / length_m, (y - start_y) / length_m
    heading, deadline_s = math.atan2(north, east), vehicle.time_s + GRACE_S + 3.0 * length_m / speed_m_s
    while True:
        at_x, at_y, _ = vehicle.pose.position_world_m.tolist()
        along_m = (at_x - start_x) * east + (at_y - start_y) * north
        across_m = (at_y - start_y) * east - (at_x - start_x) * north  # to port of the line
        if along_m >= length_m:
            return
        if vehicle.time_s > deadline_s:
            raise StoppedError(f"stuck {length_m - along_m:.1f} m before ({x:.1f}, {y:.1f}) m")
        turned = abs(wrap_angle(heading - vehicle.pose.yaw_rad)) <= TURN_FIRST_RAD
        ahead, aside = (speed_m_s if turned else 0.0), -BACK_PER_S * min(max(across_m, -1.0), 1.0)
        share = 0.0 if altitude_m is not None else 1.0 - min(max(along_m / length_m, 0.0), 1.0)
        z_m = height()
        z_m += share * (float(start[2]) - z_m) if share else 0.0
        yield from steer(vehicle, heading, (ahead * east - aside * north, ahead * north + aside * east), z_m)


def _target(
    vehicle: OwnVehicle, step: str, position_world_m: Point, altitude_m: float | None = None
) -> tuple[float, float, Callable[[], float]]:
    """Return x, y and a function that returns the height z to maintain. Raises ValueError for an invalid target."""
    point = np.asarray(position_world_m, np.float64)
    expected = (3,) if altitude_m is None else (2,)
    if point.shape != expected or not np.isfinite(point).all():
        rule = "(3,), or (2,) with altitude_m" if altitude_m is None else "(2,) with altitude_m"
        raise ValueError(f"{step}: position_world_m = {point.tolist()}: must be finite and of shape {rule}")
    x, y, *given_z = map(float, point)
    if step != "hold" and (edge := vehicle.beyond_terrain(x, y, *given_z)) is not None:
        raise ValueError(f"{step}: position_world_m = {point.tolist()}: must be above the terrain, {edge}")
    if altitude_m is None:
        z = float(point[2])
        if step != "hold" and z > 0.0:
            raise ValueError(
                f"{step}: position_world_m = {point.tolist()}: z must be at most 0 m, the mean water surface"
            )
        return x, y, lambda: z
    if (altitude := altimeter(vehicle.sensors)) is None:
        raise ValueError(f"{step}: altitude_m: the vehicle has no sensor of kind 'altitude'")
    require_positive(step, altitude_m=altitude_m)
    above_m = float(altitude_m)

    def height() -> float:
        bed_m = float(altitude.read())
        z = float(vehicle.pose.position_world_m[2])
        return min(z - bed_m + above_m, 0.0) if math.isfinite(bed_m) else z

    return x, y, height


def require_speed(step: str, speed_m_s: float) -> None:
    """Raise ValueError for a speed that no vehicle has."""
    if speed_m_s > SPEED_MAX_M_S:
        raise ValueError(f"{step}: speed_m_s = {speed_m_s:g} m/s: must be at most {SPEED_MAX_M_S:g} m/s")


def _require_finite(step: str, /, **values: float) -> None:
    for name, value in values.items():
        if not math.isfinite(value):
            raise ValueError(f"{step}: {name} = {value:g}: must be a number")


def _back_to(vehicle: OwnVehicle, x: float, y: float) -> tuple[float, float]:
    """Return a velocity that leads back to a nearby point."""
    at_x, at_y, _ = vehicle.pose.position_world_m.tolist()
    share = min(BACK_PER_S, 0.5 / max(math.hypot(x - at_x, y - at_y), 1e-9))
    return share * (x - at_x), share * (y - at_y)


def steer(
    vehicle: OwnVehicle,
    heading_rad: float,
    velocity_world_m_s: tuple[float, float],
    z_world_m: float,
    *,
    most_climb_m: float = CLIMB_M,
    autopilot: Autopilot | Controller | None = None,
) -> Steps[None]:
    """Steer for one control period, with the height error limited to most_climb_m either way.

    autopilot: defaults to the vehicle's own. Raises StoppedError if the vehicle cannot move.
    """
    require_able(vehicle)
    if most_climb_m < math.inf:
        z_m = float(vehicle.pose.position_world_m[2])
        z_world_m = z_m + min(max(z_world_m - z_m, -most_climb_m), most_climb_m)
    pilot = vehicle.autopilot if autopilot is None else autopilot
    pilot.steer(heading_rad, velocity_world_m_s, z_world_m)
    yield wait(pilot.period_s)


def require_able(vehicle: OwnVehicle) -> None:
    """Raise StoppedError if all stop is set, the battery is empty or it has capsized; watch its tilt."""
    if vehicle.all_stopped:
        raise StoppedError("all stop is set")
    if vehicle.telemetry().battery_percent <= 0.0:
        raise StoppedError("the battery is used up")
    upright = float(vehicle.pose.world_from_body[2, 2])
    vehicle.watch_tilt(upright)
    if upright < CAPSIZED_COSINE:
        raise StoppedError("capsized: the vehicle has pitched or rolled over")


def visit(vehicle: Vehicle, points_world_m: Sequence[Point], speed_m_s: float = 0.5) -> Steps[int]:
    """Undock if needed, then visit each point (3,) in turn and log `waypoint` with its number. Return their count."""
    if not vehicle.released:
        vehicle.undock()
    for number, point in enumerate(points_world_m, 1):
        yield from goto(vehicle, point, speed_m_s=speed_m_s)
        vehicle.log("waypoint", number=number)
    return len(points_world_m)
