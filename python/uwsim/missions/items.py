"""The items of MAVLink missions, uploaded or from a file: which of them can be flown, and how."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, NamedTuple, Protocol

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.mapping.files.georeference import Place
from uwsim.missions.lanes import LANE_FLOWN, LANES_FLOWN, LEAST_FLOWN, LaneEnd, lane_values, not_flown_because
from uwsim.missions.moves import SPEED_MAX_M_S, follow_leg, goto, hold, surface, turn_to
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.missions.steps import Steps, StoppedError
from uwsim.navigation.sensor_choice import altimeter

SPEED_M_S = 0.5
ABOVE_SEA, ABOVE_HOME, ABOVE_BED = (0, 5), (3, 6), (10, 11)  # MAV_FRAME; the first two are relative to the surface
HEIGHT_MAX_M, ITEMS_MAX, NEAR_BED_M = 1000.0, 1000, 1.0
FAR_M = 1e5
"""Limit of distances from the world's origin."""
TIME_MAX_S, TURNS_MAX, RADIUS_MAX_M, TURN_DEG_S = 65535.0, 255.0, 255.0, 60.0
"""Limits as wide as ArduPilot's storage of an item; TURN_DEG_S: ArduSub's rate of a turn whose item states none."""
RADIUS_MIN_M = 0.5
SURFACE_M = 0.2
"""A vehicle less deep than this is at the surface."""
CHORDS = 36  # of a circle
CONTROL_S = 0.1
UNSUPPORTED_FRAME, UNSUPPORTED, INVALID_PARAMETER, INVALID_X, INVALID_Z = 2, 3, 6, 10, 12  # MAV_MISSION_RESULT
CHANGE_SPEED, JUMP, CIRCLE, RETURN, LAND, LEFT_OUT = 178, 177, 18, 20, 21, -1
"""LEFT_OUT: in place of an item of a file that is not flown, so that the numbers of the others stand."""
WAYPOINT, PASSED = 16, (16, 17, 19, 82)
"""The items between which straight legs are flown."""
TRIGGERS = (203, 206, 2000, 2001)
"""Items that take pictures, where there is a folder for them; elsewhere they are accepted likewise."""
NOT_EXECUTED: Mapping[int, str] = {
    195: "region of interest", 196: "region of interest", 197: "region of interest", 201: "region of interest",
    530: "camera mode", 2500: "video", 2501: "end of video", 22: "take-off", 211: "gripper",
}  # fmt: skip
"""Items that are accepted and have no effect; a text names each. ArduSub, too, passes over takeoff and gripper."""


class RefusedItemError(ValueError):
    """Raised for an item that cannot be flown. result: a MAV_MISSION_RESULT."""

    def __init__(self, item: Any, result: int, reason: str) -> None:
        super().__init__(f"mission item {item.seq}: {reason}")
        self.result = result


class Ground(Protocol):
    """A vehicle and its place."""

    @property
    def home(self) -> Place:
        """The world's location on Earth."""

    @property
    def vehicle(self) -> Any:
        """The vehicle as simulated."""

    @property
    def launch_world_m(self) -> Floats:
        """The home position, at the surface."""

    @property
    def pictures(self) -> Callable[[OwnVehicle, int], object] | None:
        """Takes a picture for an item, by number; None where there is no camera or no place for pictures."""

    @property
    def send_text(self) -> Callable[[str], object]:
        """Takes a sentence about an item that is flown in another way."""


class Outputs(Protocol):
    """The outputs that items may set."""

    def refusal(self, output: float, pulse_us: float) -> tuple[int, str] | None:
        """Return the parameter that cannot be obeyed, and the rule that it breaks; None if it can be."""

    def set(self, output: int, pulse_us: float) -> None:
        """Set an output."""


@dataclass
class Pilot:
    """Flies the items of one mission. within_m: the distance at which a waypoint counts as reached.

    speed_m_s: of the next leg. passed: the last waypoint, where a leg begins. number: of the present item. legs: the
    planned length [m] of each leg between two waypoints that was begun, and how it ended. every_m, every_s: intervals
    between pictures, 0 for none. shots: how many more are taken by time, -1 for no end. shot_at: time and place of the
    last picture.
    """

    vehicle: OwnVehicle
    craft: Ground
    servos: Outputs
    within_m: float
    speed_m_s: float = SPEED_M_S
    passed: Floats | None = None
    number: int = 0
    every_m: float = 0.0
    every_s: float = 0.0
    shots: int = 0
    shot_at: tuple[float, Floats] | None = None
    legs: list[tuple[float, LaneEnd]] = field(default_factory=list)

    def place(self, item: Any) -> Floats:
        """Return an item's position; latitude and longitude 0 stand for the present ones."""
        point = self.craft.home.world_m(1e-7 * item.x, 1e-7 * item.y, item.z)
        if not (item.x or item.y):
            point[:2] = self.vehicle.pose.position_world_m[:2]
        return point

    def height_m(self, item: Any) -> float | None:
        """Return an item's height above the bed, which one below the bed has, too; None for one with an altitude."""
        if item.frame in ABOVE_BED:
            return float(item.z)
        return None if self.vehicle.beyond_terrain(*self.place(item)) is None else NEAR_BED_M

    def go(self, point: Floats, height_m: float | None = None) -> Steps[None]:
        """Fly along the leg from the last waypoint, if there is one, and to the point.

        height_m: above the bed, by the altimeter, in place of the point's z, which is then the one that it leads to.
        """
        to = point if height_m is None else point[:2]
        if self.passed is not None:
            yield from self._leg(self.passed, to, height_m)
        yield from goto(self.vehicle, to, altitude_m=height_m, speed_m_s=self.speed_m_s, within_m=self.within_m)
        if height_m is not None:
            point[2] = self.vehicle.pose.position_world_m[2]
        self.passed = point

    def _leg(self, start: Floats, to: Floats, height_m: float | None) -> Steps[None]:
        """Fly a leg, and note how much of it was flown."""
        length_m, entry_m = math.dist(start[:2], to[:2]), self._along_m(start, to)
        because = "the mission ended"
        try:
            yield from follow_leg(self.vehicle, start, to, altitude_m=height_m, speed_m_s=self.speed_m_s)
            because = ""
        except StoppedError as stop:
            because = str(stop)
            raise
        finally:
            end = LaneEnd(max(self._along_m(start, to) - entry_m, 0.0), because)
            self.legs.append((length_m, end))
            self.vehicle.log(LANE_FLOWN, **lane_values(self.number, length_m, end))

    def _along_m(self, start: Floats, to: Floats) -> float:
        """Return how far along a leg the vehicle is, between 0 and its length."""
        leg = to[:2] - start[:2]
        length_m = float(np.hypot(*leg))
        along_m = float((self.vehicle.pose.position_world_m[:2] - start[:2]) @ leg) / max(length_m, 1e-9)
        return min(max(along_m, 0.0), length_m)

    def stay(self, duration_s: float, point: Floats | None = None) -> Steps[None]:
        """Hold a position, by default the present one."""
        if duration_s > 0:
            yield from hold(self.vehicle, duration_s, position_world_m=point)

    def shoot(self) -> None:
        """Take a picture, if there is a place for it."""
        self.shot_at = self.vehicle.time_s, np.array(self.vehicle.pose.position_world_m)
        if self.craft.pictures is not None:
            self.craft.pictures(self.vehicle, self.number)

    def watched(self, steps: Steps[None]) -> Steps[None]:
        """Fly steps, and meanwhile take the pictures that are due by distance or time."""
        try:
            for pause in steps:
                yield pause
                time_s, here = self.vehicle.time_s, self.vehicle.pose.position_world_m
                if self.shot_at is None:
                    continue
                if self.every_m and math.dist(here, self.shot_at[1]) >= self.every_m:
                    self.shoot()
                elif self.every_s and self.shots and time_s - self.shot_at[0] >= self.every_s - 1e-6:
                    self.shots -= self.shots > 0
                    self.shoot()
        finally:
            steps.close()

    def surface(self) -> Steps[None]:
        """Rise where the vehicle is."""
        yield from surface(self.vehicle, within_m=SURFACE_M)
        self.passed = None


def _waypoint(pilot: Pilot, item: Any) -> Steps[None]:
    yield from pilot.go(point := pilot.place(item), pilot.height_m(item))
    yield from pilot.stay(item.param1, point)


def _loiter(pilot: Pilot, item: Any) -> Steps[None]:
    yield from pilot.go(point := pilot.place(item), pilot.height_m(item))
    yield from pilot.stay(math.inf, point)


def _circle(pilot: Pilot, item: Any) -> Steps[None]:
    """Fly to the nearest point of a circle, then along its chords. A positive radius is clockwise, seen from above."""
    centre, radius_m, height_m = pilot.place(item), abs(item.param3), pilot.height_m(item)
    east, north = pilot.vehicle.pose.position_world_m[:2] - centre[:2]
    angles = math.atan2(north, east) - math.copysign(math.tau * item.param1, item.param3) * np.linspace(
        0, 1, math.ceil(CHORDS * item.param1) + 1
    )
    points = centre + radius_m * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))])
    yield from pilot.go(points[0], height_m)
    points[:, 2] = points[0, 2]
    for start, end in pairwise(points):
        to = end if height_m is None else end[:2]
        yield from follow_leg(pilot.vehicle, start, to, altitude_m=height_m, speed_m_s=pilot.speed_m_s)
    pilot.passed = points[-1]


def _return(pilot: Pilot, item: Any) -> Steps[None]:
    """Fly home at the present depth, then rise, since home is at the surface."""
    home = pilot.craft.launch_world_m.copy()
    home[2] = pilot.vehicle.pose.position_world_m[2]
    pilot.passed = None
    yield from pilot.go(home)
    yield from pilot.surface()


def _land(pilot: Pilot, item: Any) -> Steps[None]:
    """Fly to a place, if there is one, at the present depth, then rise: to land is to surface for an ArduSub."""
    if item.x or item.y:
        point = pilot.place(item)
        point[2] = pilot.vehicle.pose.position_world_m[2]
        yield from pilot.go(point)
    yield from pilot.surface()


def _turn(pilot: Pilot, item: Any) -> Steps[None]:
    """Turn on the spot at a rate: to an angle from north the shortest way, or by an angle in a direction."""
    pose = pilot.vehicle.pose
    angle_rad = math.radians(item.param1)
    if item.param4:
        left_rad = -math.copysign(angle_rad, item.param3 or 1)
    else:
        left_rad = math.remainder(math.pi / 2 - angle_rad - pose.yaw_rad, math.tau)
    count = math.ceil(abs(left_rad) / (math.radians(item.param2 or TURN_DEG_S) * CONTROL_S))
    here = np.array(pose.position_world_m)
    for k in range(1, count + 1):
        heading_rad = pose.yaw_rad + left_rad * k / count
        yield from hold(pilot.vehicle, CONTROL_S, position_world_m=here, heading_rad=heading_rad)
    yield from turn_to(pilot.vehicle, pose.yaw_rad + left_rad)


def _change_speed(pilot: Pilot, item: Any) -> Steps[None]:
    pilot.speed_m_s = item.param2
    yield from ()


def _jump(pilot: Pilot, item: Any) -> Steps[None]:
    yield from pilot.stay(CONTROL_S)  # so that jumps in a circle take time


def _skip(pilot: Pilot, item: Any) -> Steps[None]:
    yield from ()


def _set_servo(pilot: Pilot, item: Any) -> Steps[None]:
    pilot.servos.set(int(item.param1), item.param2)
    yield from ()


def _picture(pilot: Pilot, item: Any) -> Steps[None]:
    if item.x != 0:  # the shoot command, param5
        pilot.shoot()
    yield from ()


def _by_distance(pilot: Pilot, item: Any) -> Steps[None]:
    """Take a picture at each distance from the last one, 0 for none; param3: the first one at once."""
    pilot.every_m, pilot.every_s = item.param1, 0.0
    pilot.shot_at = pilot.vehicle.time_s, np.array(pilot.vehicle.pose.position_world_m)
    if item.param1 and item.param3:
        pilot.shoot()
    yield from ()


def _by_time(pilot: Pilot, item: Any) -> Steps[None]:
    """Take pictures, the first one at once; param2: the interval, param3: how many, 0 for no end."""
    pilot.every_m, pilot.every_s, pilot.shots = 0.0, item.param2, int(item.param3) - 1
    pilot.shoot()
    yield from ()


def _no_more(pilot: Pilot, item: Any) -> Steps[None]:
    pilot.every_m = pilot.every_s = 0.0
    yield from ()


Limits = tuple[str, float, float, str]
"""A parameter's meaning, its least and greatest value, and its unit."""


class ItemKind(NamedTuple):
    """A kind of item. is_placed: whether it has a position. limits: of its parameters, by number from 1."""

    name: str
    fly: Callable[[Pilot, Any], Steps[None]]
    is_placed: bool
    limits: Mapping[int, Limits]


SECONDS: Limits = ("hold", 0.0, TIME_MAX_S, "s")
KINDS: Mapping[int, ItemKind] = {
    16: ItemKind("waypoint", _waypoint, True, {1: SECONDS}),
    17: ItemKind("loiter", _loiter, True, {}),
    CIRCLE: ItemKind(
        "circle", _circle, True, {1: ("turns", 0.0, TURNS_MAX, ""), 3: ("radius", -RADIUS_MAX_M, RADIUS_MAX_M, "m")}
    ),
    19: ItemKind("loiter for a time", _waypoint, True, {1: SECONDS}),
    RETURN: ItemKind("return", _return, False, {}),
    LAND: ItemKind("surface", _land, True, {}),
    82: ItemKind("spline waypoint", _waypoint, True, {1: SECONDS}),
    93: ItemKind("delay", lambda pilot, item: pilot.stay(item.param1), False, {1: ("delay", 0.0, TIME_MAX_S, "s")}),
    115: ItemKind(
        "yaw", _turn, False,
        {1: ("angle", 0.0, 360.0, "deg"), 2: ("rate", 0.0, 90.0, "deg/s"), 3: ("direction", -1, 1, ""),
         4: ("relative", 0, 1, "")},
    ),
    JUMP: ItemKind("jump", _jump, False, {2: ("repeats", -1, TIME_MAX_S, "")}),
    LEFT_OUT: ItemKind("left out", _skip, False, {}),
    CHANGE_SPEED: ItemKind(
        "speed", _change_speed, False, {1: ("type", 0, 1, ""), 2: ("speed", 0.01, SPEED_MAX_M_S, "m/s")}
    ),
    203: ItemKind("camera trigger", _picture, False, {}),
    206: ItemKind("camera trigger by distance", _by_distance, False, {1: ("distance", 0.0, FAR_M, "m")}),
    2000: ItemKind(
        "camera trigger by time", _by_time, False,
        {2: ("interval", 0.0, TIME_MAX_S, "s"), 3: ("pictures", 0.0, TIME_MAX_S, "")},
    ),
    2001: ItemKind("end of camera triggers", _no_more, False, {}),
    183: ItemKind("servo", _set_servo, False, {}),
    **{number: ItemKind(name, _skip, False, {}) for number, name in NOT_EXECUTED.items()},
}  # fmt: skip
"""The items that can be flown, by MAV_CMD. Another item takes one entry."""
WHOLE = {115: (3, 4), CHANGE_SPEED: (1,), JUMP: (1, 2)}
"""Parameters that must be whole numbers."""


def checked(item: Any, craft: Ground, servos: Outputs) -> Any:
    """Return the item if it can be flown. Raises RefusedItemError."""
    if item.seq == 0:  # ArduPilot keeps the home position here
        return item
    kind = KINDS.get(item.command)
    if kind is None:
        known = ", ".join(
            f"{each.name} ({number})" for number, each in KINDS.items() if number not in (*NOT_EXECUTED, LEFT_OUT)
        )
        raise RefusedItemError(item, UNSUPPORTED, f"command {item.command}: must be {known}")
    for number, (meaning, low, high, unit) in kind.limits.items():
        value = getattr(item, f"param{number}")
        if not low <= value <= high or (number in WHOLE.get(item.command, ()) and value != int(value)):
            stated = f"{meaning} = {value:g} {unit}".rstrip()
            raise RefusedItemError(item, INVALID_PARAMETER + number - 1, f"{stated}: must be in [{low:g}, {high:g}]")
    if item.command == CIRCLE and abs(item.param3) < RADIUS_MIN_M:
        reason = f"radius = {item.param3:g} m: must be {RADIUS_MIN_M:g} m or more"
        raise RefusedItemError(item, INVALID_PARAMETER + 2, reason)
    if item.command == JUMP and not 1 <= item.param1 <= ITEMS_MAX:
        raise RefusedItemError(item, INVALID_PARAMETER, f"jump to item {item.param1:g}: must be 1 or more")
    if item.command in NOT_EXECUTED or (item.command in TRIGGERS and craft.pictures is None):
        craft.send_text(f"mission item {item.seq}: {kind.name}: has no effect")
    if item.command == 82:
        craft.send_text(f"mission item {item.seq}: spline: is flown straight")
    if item.command == 183 and (why := servos.refusal(item.param1, item.param2)):
        raise RefusedItemError(item, INVALID_PARAMETER + why[0] - 1, f"servo param{why[0]}: must be {why[1]}")
    if kind.is_placed:
        _check_place(item, craft)
    return item


def _check_place(item: Any, craft: Ground) -> None:
    if item.frame in ABOVE_BED:
        _check_height(item, craft)
    elif item.frame not in ABOVE_SEA + ABOVE_HOME:
        raise RefusedItemError(
            item, UNSUPPORTED_FRAME, f"frame {item.frame}: must be a global one (0, 3, 5, 6, 10, 11)"
        )
    elif not -FAR_M < item.z <= 0:
        rule = f"must not be above the surface, 0 m, nor below {-FAR_M:g} m"
        raise RefusedItemError(item, INVALID_Z, f"altitude = {item.z:g} m: {rule}")
    altitude_m = 0.0 if item.frame in ABOVE_BED or item.command == LAND else item.z
    east, north, up = (float(part) for part in craft.home.world_m(1e-7 * item.x, 1e-7 * item.y, altitude_m))
    if not (item.x or item.y) or (edge := craft.vehicle.beyond_terrain(east, north, up)) is None:
        return
    if craft.vehicle.beyond_terrain(east, north) is None and altimeter(craft.vehicle.sensors) is not None:
        rule = f"is below the bed, {edge}: {NEAR_BED_M:g} m above the bed is flown"  # as deep as an ArduSub gets
        craft.send_text(f"mission item {item.seq}: altitude = {item.z:g} m: {rule}")
    else:
        place = f"({east:.1f}, {north:.1f}, {up:.1f}) m east, north and up of the origin"
        raise RefusedItemError(item, INVALID_X, f"position {place}: must be above the terrain, {edge}")


def _check_height(item: Any, craft: Ground) -> None:
    if item.command not in (16, 17, 19, 82):
        raise RefusedItemError(item, UNSUPPORTED_FRAME, f"frame {item.frame}: is for waypoints; must be 0, 3, 5 or 6")
    if altimeter(craft.vehicle.sensors) is None:
        rule = "is above the bed, and the vehicle has no sensor of kind 'altitude'"
        raise RefusedItemError(item, UNSUPPORTED_FRAME, f"frame {item.frame}: {rule}")
    if not 0 < item.z <= HEIGHT_MAX_M:
        rule = f"height = {item.z:g} m above the bed: must be in (0, {HEIGHT_MAX_M:g}]"
        raise RefusedItemError(item, INVALID_Z, rule)


def fly_items(
    pilot: Pilot, items: Sequence[Any], first: int, begun: Callable[[int], object], reached: Callable[[int], object]
) -> Steps[None]:
    """Fly items, numbered from 1, in turn from `first` on, at the speed that the ones before have set.

    begun, reached: called with each item's number. The lengths of legs that are planned and flown are logged at the
    end. Raises StoppedError if less than 95 % of the legs was flown.
    """
    for item in items[: first - 1]:
        if item.command == CHANGE_SPEED:
            pilot.speed_m_s = item.param2
    left: Sequence[Any] = ()
    try:
        for number, item in course(items, first):
            pilot.number, left = item.seq, items[number - 1 :]
            begun(item.seq)
            yield from pilot.watched(KINDS[item.command].fly(pilot, item))
            reached(item.seq)
        left = ()
    finally:
        left_m = list(planned_legs_m(left, pilot.craft.home))
        planned_m = sum(length_m for length_m, _ in pilot.legs) + sum(left_m)
        flown_m, lanes = sum(end.flown_m for _, end in pilot.legs), len(pilot.legs) + len(left_m)
        values = {"lanes": lanes, "flown_m": round(flown_m, 2), "planned_m": round(planned_m, 2)}
        if lanes:
            pilot.vehicle.log(LANES_FLOWN, **values)
    if flown_m < LEAST_FLOWN * planned_m:
        raise StoppedError(not_flown_because(flown_m, planned_m, (end for _, end in pilot.legs)))


def course(items: Sequence[Any], first: int) -> Iterator[tuple[int, Any]]:
    """Yield the number and the item that is flown next, with all jumps."""
    number, jumped = max(first, 1), dict[int, int]()
    while number <= len(items):
        item = items[number - 1]
        yield number, item
        number += 1
        if item.command == JUMP and (item.param2 < 0 or jumped.get(item.seq, 0) < item.param2):
            jumped[item.seq] = jumped.get(item.seq, 0) + 1
            number = int(item.param1)


def planned_legs_m(items: Iterable[Any], place: Place) -> Iterator[float]:
    """Yield the lengths of the straight legs between waypoints, without repetitions."""
    before = None
    for item in items:
        if item.command in PASSED and (item.x or item.y):
            here = place.world_m(1e-7 * item.x, 1e-7 * item.y, 0.0)
            if before is not None:
                yield math.dist(before[:2], here[:2])
            before = here
        elif KINDS[item.command].is_placed or item.command == RETURN:
            before = None
