"""A flight by a file of the field: its items are checked against the vehicle and its world before it begins."""

from __future__ import annotations

import warnings
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.base.named import did_you_mean
from uwsim.flight.mission_file import MissionError
from uwsim.mapping.files.georeference import Home, Place
from uwsim.missions.fence import Fence
from uwsim.missions.field import Area, FieldMission, Item, read_mission_file
from uwsim.missions.field.mission import sentence
from uwsim.missions.items import (
    CHANGE_SPEED,
    FAR_M,
    HEIGHT_MAX_M,
    KINDS,
    LEFT_OUT,
    NOT_EXECUTED,
    PASSED,
    SPEED_M_S,
    TRIGGERS,
    Pilot,
    RefusedItemError,
    checked,
    fly_items,
)
from uwsim.missions.lawn_mower import mow
from uwsim.missions.lawn_mower_plan import LawnMowerPlan, missing_for_lanes
from uwsim.missions.moves import SPEED_MAX_M_S, reached_m
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.missions.pictures import PictureFolder
from uwsim.missions.run import MissionFunction
from uwsim.missions.steps import Steps
from uwsim.scenario.georeference import georeference
from uwsim.simulator.simulator import Simulator

SERVO, PICTURES = 183, "pictures"
PLACES = "; --set first_at_m=[X,Y] places the file's first point elsewhere in the world"
NAMES = {22: "take-off", 84: "VTOL take-off", 85: "VTOL landing", 189: "start of a landing", 205: "mount"}
"""Kinds of items that are not flown and have a common name, by MAV_CMD."""


class FieldNote(UserWarning):
    """Issued for what is in a file of the field and not flown, or flown in another way."""


@dataclass(frozen=True)
class FieldSettings:
    """The values that a user gives to a flight by a file, as `uwsim run FILE --set NAME=VALUE`.

    altitude_m: height of all waypoints above the bed, in place of the file's altitudes. depth_m: depth, likewise.
    speed_m_s: in place of the file's speeds. spacing_m: distance between the lanes over an area, in place of the
    file's. first_at_m: the place (x, y) in the world of the file's first point, or of the middle of its first area if
    it has no point, in place of where it is on Earth.
    """

    altitude_m: float | None = None
    depth_m: float | None = None
    speed_m_s: float | None = None
    spacing_m: float | None = None
    first_at_m: tuple[float, float] | None = None

    @classmethod
    def of(cls, arguments: Mapping[str, Any]) -> FieldSettings:
        """Return the settings given by name. Raises MissionError."""
        known = [each.name for each in fields(cls)]
        for name in arguments:
            if name not in known:
                rule = f"must be one of {', '.join(known)}"
                raise MissionError(f"mission argument '{name}': {rule}{did_you_mean(name, known)}")
        bounds = {
            "altitude_m": (HEIGHT_MAX_M, "m"),
            "depth_m": (FAR_M, "m"),
            "spacing_m": (HEIGHT_MAX_M, "m"),
            "speed_m_s": (SPEED_MAX_M_S, "m/s"),
        }
        for name, (high, unit) in bounds.items():
            value = arguments.get(name)
            if value is not None and not (_is_number(value) and 0 < value <= high):
                raise MissionError(f"mission argument {name} = {value!r:.40} {unit}: must be in (0, {high:g}]")
        if None not in (arguments.get("altitude_m"), arguments.get("depth_m")):
            raise MissionError("mission arguments altitude_m and depth_m: must not both be given")
        at = arguments.get("first_at_m")
        if at is not None:
            if not (isinstance(at, list | tuple) and len(at) == 2 and all(map(_is_number, at))):
                raise MissionError(f"mission argument first_at_m = {at!r:.40} m: must be two numbers, as [10, -5]")
            arguments = {**arguments, "first_at_m": (float(at[0]), float(at[1]))}
        return cls(**arguments)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= FAR_M


@dataclass
class _Ground:
    """A vehicle and its place; see uwsim.missions.items.Ground."""

    home: Place
    vehicle: Any
    launch_world_m: Floats
    send_text: Callable[[str], object]
    pictures: Callable[[OwnVehicle, int], object] | None = None


class _NoOutputs:
    """In place of outputs: a flight by a file sets none."""

    def refusal(self, output: float, pulse_us: float) -> tuple[int, str] | None:
        """Refuse nothing, since items with outputs are left out."""
        return None

    def set(self, output: int, pulse_us: float) -> None:
        """Raise NotImplementedError."""
        raise NotImplementedError


@dataclass(frozen=True)
class FieldFlight:
    """The flight by a file."""

    file: Path
    mission: FieldMission
    settings: FieldSettings

    @classmethod
    def of(cls, file: Path, arguments: Mapping[str, Any]) -> FieldFlight:
        """Read a file. Raises ValueError or OSError."""
        return cls(file, read_mission_file(file), FieldSettings.of(arguments))

    def bound(self, sim: Simulator, names: tuple[str, ...], out: Path | None) -> MissionFunction:
        """Return the mission of these vehicles, and warn of all that is not flown.

        out: the folder of the flight's results, with those of its pictures, if there is one.
        Raises MissionError for an item that they cannot fly.
        """
        grounds, flown, plans, fences, notes = {}, {}, {}, {}, dict.fromkeys(self.mission.notes)
        for name in names:
            vehicle = sim.vehicles[name]
            launch = np.asarray(vehicle.pose.position_world_m) * np.array([1.0, 1.0, 0.0])
            has_pictures = out is not None and bool(vehicle.cameras)
            items = self._items(notes, has_pictures=has_pictures)
            areas = [area for area in self.mission.areas if not area.in_items]
            if not areas and all(item.command == LEFT_OUT for item in items):
                raise MissionError(f"{self.file}: has nothing that can be flown: {'; '.join(notes)}")
            home = self._place(sim, launch, items, notes)
            grounds[name] = ground = _Ground(home, vehicle, launch, lambda text: notes.setdefault(text))
            if out is not None and has_pictures:
                folder = out / PICTURES if len(names) == 1 else out / PICTURES / name
                ground.pictures = PictureFolder(folder, home).take
            for item in items:
                try:
                    checked(item, ground, _NoOutputs())
                except RefusedItemError as error:
                    raise MissionError(f"{self.file}: {error}{self._hint(error)}") from None
            flown[name] = items
            plans[name] = [self._plan(area, ground) for area in areas]
            fences[name] = self._fence(vehicle, ground, items, plans[name])
        for note in notes:
            warnings.warn(f"{self.file}: {note}", FieldNote, stacklevel=2)
        speed_m_s = self.settings.speed_m_s or SPEED_M_S

        def mission(vehicle: OwnVehicle) -> Steps[int]:
            for note in notes:
                vehicle.log("note", text=note)
            if not vehicle.released:
                vehicle.undock()
            pilot = Pilot(vehicle, grounds[vehicle.name], _NoOutputs(), reached_m(vehicle), speed_m_s)
            items = flown[vehicle.name]
            fence = fences[vehicle.name]
            steps = fly_items(
                pilot, items, 1, lambda number: None, lambda number: vehicle.log("item_reached", number=number)
            )
            yield from fence.kept(vehicle, steps)
            for plan in plans[vehicle.name]:
                yield from fence.kept(vehicle, mow(vehicle, plan))
            return len(items)

        return mission

    def _fence(self, vehicle: Any, ground: _Ground, items: list[Item], plans: list[LawnMowerPlan]) -> Fence:
        """Return the file's fence. Raises MissionError for a start, an item or a lane that is not within it."""
        fence = Fence(self.mission.fence, ground.home)
        start_m = np.asarray(vehicle.pose.position_world_m)[:2]
        if (why := fence.breach(start_m)) is not None:
            where = f"the start of vehicle '{vehicle.name}', ({start_m[0]:.1f}, {start_m[1]:.1f}) m,"
            raise MissionError(f"{self.file}: {where} {why}{PLACES}")
        if (why := fence.refusal(items, start_m)) is not None:
            raise MissionError(f"{self.file}: {why}")
        for lane in (lane for plan in plans for lane in plan.lanes_near(start_m)):
            if (why := fence.breach(lane.start_m, lane.end_m)) is not None:
                ends = " to ".join(f"({x:.1f}, {y:.1f}) m" for x, y in (lane.start_m, lane.end_m))
                raise MissionError(f"{self.file}: a lane from {ends} {why}")
        return fence

    def _plan(self, area: Area, ground: _Ground) -> LawnMowerPlan:
        """Return the plan of an area's lanes. Raises MissionError."""
        given, where = self.settings, f"{self.file}: {area.name}"
        altitude_m, spacing_m = given.altitude_m or area.altitude_m, given.spacing_m or area.spacing_m
        for name, value in (("altitude_m", altitude_m), ("spacing_m", spacing_m)):
            if not value:
                raise MissionError(f"{where}: has no {name.removesuffix('_m')}: --set {name}=3 gives it")
        corners = [ground.home.world_m(*corner, 0.0)[:2].tolist() for corner in area.corners]
        for x, y in corners:
            if (edge := ground.vehicle.beyond_terrain(x, y)) is not None:
                raise MissionError(
                    f"{where}: corner at ({x:.1f}, {y:.1f}) m: must be above the terrain, {edge}{PLACES}"
                )
        if missing := missing_for_lanes(ground.vehicle, altitude_m or 0.0):
            raise MissionError(f"{where}: the vehicle cannot fly lanes: {'; '.join(missing.values())}")
        return LawnMowerPlan(
            corners, altitude_m or 0.0, spacing_m or 0.0, given.speed_m_s or SPEED_M_S, heading_deg=area.heading_deg
        )

    def _items(self, notes: dict[str, None], *, has_pictures: bool) -> list[Item]:
        """Return the items to fly; note those that are left out, by kind, and the heights and speeds replaced."""
        given, left_out, items = self.settings, defaultdict[str, list[int]](list), []
        for item in self.mission.items:
            kind = KINDS.get(item.command)
            if kind is None or item.command in (*NOT_EXECUTED, SERVO, *([] if has_pictures else TRIGGERS)):
                name = kind.name if kind else NAMES.get(item.command, "unknown")
                if item.command in TRIGGERS:
                    name += ", for which there is no camera or no folder"
                left_out[f"{name} ({item.command})"].append(item.seq)
                item = replace(item, command=LEFT_OUT)
            elif item.command == CHANGE_SPEED and (given.speed_m_s is not None or item.param2 <= 0):
                why = "replaced by speed_m_s" if given.speed_m_s is not None else "no change"
                left_out[f"speed of {item.param2:g} m/s, {why}"].append(item.seq)
                item = replace(item, command=LEFT_OUT)
            elif item.command in PASSED and given.altitude_m is not None:
                item = replace(item, frame=10, z=given.altitude_m)
            elif kind.is_placed and given.depth_m is not None:
                item = replace(item, frame=3, z=-given.depth_m)
            items.append(item)
        for what, numbers in left_out.items():
            notes.setdefault(sentence(what, numbers, "left out"))
        if given.altitude_m is not None:
            notes.setdefault(
                f"all waypoints are flown {given.altitude_m:g} m above the bed, not at the file's altitudes"
            )
        if given.depth_m is not None:
            notes.setdefault(f"all items are flown {given.depth_m:g} m deep, not as high as in the file")
        return items

    def _place(self, sim: Simulator, launch: Floats, items: list[Item], notes: dict[str, None]) -> Place:
        """Return where the world is on Earth; for a world that is nowhere, the first point is at the vehicle."""
        place, at = georeference(sim.scenario), self.settings.first_at_m
        if place.crs is not None and at is None:
            return place
        first = next((item for item in items if KINDS[item.command].is_placed and (item.x or item.y)), None)
        if first is None and not self.mission.areas:
            return Home(*(self.mission.home or (0.0, 0.0)))
        lat, lon = (
            (1e-7 * first.x, 1e-7 * first.y) if first else np.mean(self.mission.areas[0].corners, axis=0).tolist()
        )
        x, y = (float(launch[0]), float(launch[1])) if at is None else at
        if at is None:
            what = f"item {first.seq}, the first point," if first else f"the middle of {self.mission.areas[0].name}"
            notes.setdefault(
                f"scenario '{sim.scenario.name}' is not on Earth: {what} is assumed at the "
                f"vehicle's start, ({x:.1f}, {y:.1f}) m east and north of the origin; first_at_m places it elsewhere"
            )
        return Home(lat, lon, x, y)

    def _hint(self, error: RefusedItemError) -> str:
        text = str(error)
        if "above the surface" in text or "above the bed" in text:
            return "; --set altitude_m=3 flies all waypoints 3 m above the bed instead, --set depth_m=3 at that depth"
        if "above the terrain" in text:
            return PLACES
        return ""
