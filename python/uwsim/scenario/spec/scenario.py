"""A scenario: the environment, obstacles, vehicles and survey."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, PrivateAttr, model_validator

from uwsim.base.named import did_you_mean
from uwsim.scenario.read.spec_file import SourceFile
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.cover import Cover, Life
from uwsim.scenario.spec.fault import FaultSpec
from uwsim.scenario.spec.fields import InRange, Model, Name, broken
from uwsim.scenario.spec.link import LinkSpec
from uwsim.scenario.spec.loose_body import LooseBody
from uwsim.scenario.spec.material import Ground
from uwsim.scenario.spec.obstacle import ObstacleSpec
from uwsim.scenario.spec.optics import Optics
from uwsim.scenario.spec.pinger import Pinger, Sound
from uwsim.scenario.spec.prop import PropEntry
from uwsim.scenario.spec.settings import Dynamics, Earth, Station, View, WarningLimits
from uwsim.scenario.spec.survey import Survey
from uwsim.scenario.spec.terrain import TerrainSpec
from uwsim.scenario.spec.tether import BodyAnchor, Tethered
from uwsim.scenario.spec.vehicle import VehicleModel
from uwsim.scenario.spec.vehicle_entry import VehicleEntry
from uwsim.scenario.spec.water import Water
from uwsim.scenario.spec.water_parts import LINK_MOST_M_S, OPTICS_MOST_M_S, WaterTargetSpec, Wind, in_wind

MOST_OBJECTS = 200
RESERVED_NAMES = ("nothing", "terrain", "station")
WITHOUT_STATION = Station.model_construct(dock_m=(0.0, 0.0, -2.0))
"""The default station: a point on the water above the world's origin, with its dock 2 m below."""


class Scenario(Model):
    """All inputs that determine a run's results. World frame: ENU, z up, water surface at z = 0.

    name: name of the scenario. seed: determines all random draws, such as sensor noise. step_s: step size of the
    simulation. dynamics: what moves the vehicles. earth: where on Earth the world's origin is; by default unknown,
    unless the terrain has a coordinate system. water: its surface, currents and profile. wind: over it; by default
    none. optics: optical conditions for cameras. terrain: the bed. ground: its materials. detail: `fine` lets cameras
    see the relief and patterns of fixed surfaces down to a pixel's footprint (pebbles, pits, grain), and ripples of
    sand across the waves; no other sensor perceives them. view: from where stills show the scenario, and `uwsim
    scenario camera` looks unless it is given a pose; by default the start of the first vehicle. obstacles: fixed
    obstacles in the water. cover: layers of stones, plants and animals on the bed: stones stop bodies, plants brake
    them. life: fish, which instruments meet. water_targets: fish and bubbles, which a multibeam in physics mode
    receives. station: the reference for distances; it has the dock. vehicles: at least one. objects: loose bodies and
    bodies on paths. props: sets of obstacles and objects, such as a bin with its lid, each placed as one; those of a
    course, say. pingers: sources of sound for hydrophones; sound: what else those hear.
    warnings: when the panel issues warnings. survey: the survey flown by `uwsim survey`. mission_time_s: battery life
    after the release of a vehicle without a `battery`, and the default time limit of a flight. link: the link between
    station and vehicles; None: messages are delivered immediately. faults: what fails, and when. wire: the topics that
    servers offer unless they are asked for others: `standard` (ROS's usual ones), `published` (those of the paper's
    simulator, in its coordinates: water surface at z = 75.3 m) or `both`.
    """

    name: Name
    description: str = ""
    seed: Annotated[int, InRange(0, 2**63 - 1)] = 0
    step_s: Annotated[float, InRange(0.0005, 0.02, "s")] = 0.005
    mission_time_s: Annotated[float, InRange(1, 1e6, "s")] = 3600.0
    dynamics: Dynamics = Dynamics.model_construct()
    earth: Earth | None = None
    water: Water = Water.model_construct()
    wind: Wind | None = None
    optics: Optics = Optics.model_construct()
    terrain: TerrainSpec
    ground: Ground = Ground.model_construct()
    detail: Literal["fine"] | None = None
    view: View | None = None
    obstacles: Annotated[tuple[ObstacleSpec, ...], Field(max_length=10_000)] = ()
    cover: Cover = ()
    life: Life | None = None
    water_targets: Annotated[tuple[WaterTargetSpec, ...], Field(max_length=100)] = ()
    station: Station = WITHOUT_STATION
    vehicles: Annotated[tuple[VehicleEntry, ...], Field(min_length=1, max_length=64)]
    objects: Annotated[tuple[LooseBody, ...], Field(max_length=MOST_OBJECTS)] = ()
    props: Annotated[tuple[PropEntry, ...], Field(max_length=200)] = ()
    pingers: Annotated[tuple[Pinger, ...], Field(max_length=100)] = ()
    sound: Sound = Sound.model_construct()
    warnings: WarningLimits = WarningLimits.model_construct()
    link: LinkSpec | None = None
    survey: Survey | None = None
    faults: Annotated[tuple[FaultSpec, ...], Field(max_length=1000)] = ()
    wire: Literal["standard", "published", "both"] = "both"

    _source_file: SourceFile = PrivateAttr(default=SourceFile())
    _placed_props: tuple[PropEntry, ...] = PrivateAttr(default=())

    def __repr__(self) -> str:
        vehicles = ", ".join(vehicle.name for vehicle in self.vehicles)
        about = f"seed {self.seed}, {len(self.obstacles)} obstacles, vehicles {vehicles}"
        return f"<Scenario '{self.name}': {about}; {' '.join(self.description.split())}>"

    __str__ = __repr__

    @model_validator(mode="after")
    def _props_are_placed(self) -> Scenario:
        if not self.props:
            return self
        obstacles = [*self.obstacles, *(one for prop in self.props for one in prop.obstacles())]
        objects = [*self.objects, *(one for prop in self.props for one in prop.objects())]
        if len(objects) > MOST_OBJECTS:
            raise broken(f"give {len(objects)} bodies with all objects: must be at most {MOST_OBJECTS}", at=("props",))
        pingers = [*self.pingers, *(one for prop in self.props for one in prop.pingers())]
        self._placed_props = self.props
        self.__dict__.update(obstacles=tuple(obstacles), objects=tuple(objects), pingers=tuple(pingers), props=())
        self.model_fields_set.update(("obstacles", "objects", "pingers"))
        return self

    @model_validator(mode="after")
    def _objects_are_scattered(self) -> Scenario:
        if all(entry.scatter is None for entry in self.objects):
            return self
        bodies: list[LooseBody] = []
        for index, entry in enumerate(self.objects):
            count, at = 1 if entry.scatter is None else entry.scatter.count, ("objects", index, "scatter")
            if not 1 <= count <= MOST_OBJECTS - len(bodies):
                rule = f"gives {count} bodies: must be at least 1, and at most {MOST_OBJECTS} with all other objects"
                raise broken(rule, at=at)
            scattered = entry.scattered()
            if not scattered:
                rule = f"leaves no room for {count} bodies; give fewer, a larger area_m or a smaller apart_m"
                raise broken(rule, at=at)
            bodies += scattered
        self.__dict__["objects"] = tuple(bodies)
        return self

    @model_validator(mode="after")
    def _names_are_unique(self) -> Scenario:
        taken = set(RESERVED_NAMES)
        for kind, items in (
            ("obstacles", self.obstacles),
            ("cover", self.cover),
            ("life", self.life or ()),
            ("water_targets", self.water_targets),
            ("vehicles", self.vehicles),
            ("objects", self.objects),
        ):
            for index, item in enumerate(items):
                if item.name in taken:
                    at = (kind, index, *(("shape",) if kind == "objects" else ()), "name")
                    raise broken("is already in use", at=at, value=item.name)
                taken.add(item.name)
        return self

    @model_validator(mode="after")
    def _has_one_wind(self) -> Scenario:
        if self.wind is not None:
            self.__dict__["optics"] = in_wind(self.optics, OPTICS_MOST_M_S, self.wind)
            self.__dict__["sound"] = in_wind(self.sound, LINK_MOST_M_S, self.wind)
            if self.link is not None:
                self.__dict__["link"] = in_wind(self.link, LINK_MOST_M_S, self.wind)
        return self

    @model_validator(mode="after")
    def _pingers_are_heard(self) -> Scenario:
        names = [each.name for each in self.pingers]
        for index, each in enumerate(self.pingers):
            if each.name in names[:index]:
                raise broken("is already in use", at=("pingers", index, "name"), value=each.name)
            if each.position_m[2] > 0:
                raise broken("must be under water", at=("pingers", index, "position_m"), value=list(each.position_m))
            if self.sound.pool is not None and not self.sound.pool.holds(each.position_m):
                raise broken("must be in sound.pool", at=("pingers", index, "position_m"), value=list(each.position_m))
        return self

    @model_validator(mode="after")
    def _carrier_is_free(self) -> Scenario:
        carrier = self.station.carrier
        if carrier is None:
            return self
        names = [vehicle.name for vehicle in self.vehicles]
        if carrier not in names:
            rule = f"must be one of the vehicles, {', '.join(names)}{did_you_mean(carrier, names)}"
            raise broken(rule, at=("station", "carrier"), value=carrier)
        index = names.index(carrier)
        if self.vehicles[index].start is None:
            raise broken(
                "it carries the station; give it a position_m", at=("vehicles", index, "start"), value="station"
            )
        tether = self.vehicles[index].tether
        if tether is not None and tether.anchor == "station":
            raise broken("it carries the station; give a point", at=("vehicles", index, "tether", "anchor"))
        return self

    @model_validator(mode="after")
    def _is_placed_once(self) -> Scenario:
        if self.earth is not None and self.terrain.has_place:
            rule = "must be left out, as the terrain's file has a place on Earth; with terrain.crs: local, it has none"
            raise broken(rule, at=("earth",))
        return self

    @model_validator(mode="after")
    def _tethers_are_fastened(self) -> Scenario:
        for one in self.tethered:
            anchor = one.tether.anchor
            if not isinstance(anchor, BodyAnchor):
                continue
            names = [vehicle.name for vehicle in self.vehicles] + [body.name for body in self.objects]
            names.remove(one.name)
            if anchor.to not in names:
                rule = f"must be another vehicle or a loose body: {', '.join(names) or 'there is none'}"
                at = (*one.keys, "tether", "anchor", "to")
                raise broken(rule + did_you_mean(anchor.to, names), at=at, value=anchor.to)
        return self

    @model_validator(mode="after")
    def _droppers_hold_loose_bodies(self) -> Scenario:
        loose = [one.name for one in self.objects if not (one.path or one.fixed or one.links or one.tether)]
        taken: set[str] = set()
        for index, vehicle in enumerate(self.vehicles):
            for name, dropper in vehicle.droppers.items():
                for number, held in enumerate(dropper.holds):
                    at = ("vehicles", index, "droppers", name, "holds", number)
                    if held not in loose:
                        rule = f"must be an object that nothing else holds: {', '.join(loose) or 'there is none'}"
                        raise broken(rule + did_you_mean(held, loose), at=at, value=held)
                    if held in taken:
                        raise broken("is already in a dropper", at=at, value=held)
                    taken.add(held)
        return self

    @model_validator(mode="after")
    def _uncertainties_are_known(self) -> Scenario:
        limit_m = None if self.survey is None else self.survey.max_uncertainty_m
        multibeams = [vehicle.sonar for vehicle in self.vehicles if vehicle.model.sonar is not None]
        if limit_m is not None and not all(sonar.mode == "physics" for sonar in multibeams):
            rule = "needs a sonar with `mode: physics`, also on each other vehicle with a multibeam"
            raise broken(rule, at=("survey", "max_uncertainty_m"), value=limit_m, unit="m")
        return self

    @model_validator(mode="after")
    def _at_most_one_is_docked(self) -> Scenario:
        docked = [index for index, vehicle in enumerate(self.vehicles) if vehicle.start is None]
        if len(docked) > 1:
            rule = "the dock holds one vehicle; give this one a position_m"
            raise broken(rule, at=("vehicles", docked[1], "start"), value="station")
        return self

    @property
    def tethered(self) -> list[Tethered]:
        """The vehicles and objects with a tether, in the order of the core's tethers."""
        vehicles = [(("vehicles", index), each.name, each.tether) for index, each in enumerate(self.vehicles)]
        objects = [(("objects", index), each.name, each.tether) for index, each in enumerate(self.objects)]
        return [
            Tethered(number, keys, name, tether)
            for number, (keys, name, tether) in enumerate(vehicles + objects)
            if tether is not None
        ]

    @property
    def source_file(self) -> SourceFile:
        """The file from which the scenario was read, for messages."""
        return self._source_file

    @property
    def placed_props(self) -> tuple[PropEntry, ...]:
        """The props whose parts are the last of its obstacles and objects, if it was read with props."""
        return self._placed_props

    def read_from(self, source_file: SourceFile) -> Self:
        """Return a copy whose errors refer to this file and its lines."""
        copy = super().model_copy()
        copy._source_file = source_file
        return copy

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return pydantic's copy; a copy with updates no longer refers to the file."""
        copy = super().model_copy(update=update, deep=deep)
        return copy.read_from(SourceFile()) if update else copy

    def with_changes(
        self,
        *,
        seed: int | None = None,
        mission_time_s: float | None = None,
        sonar_model: int | str | Path | None = None,
        sonar_frequency_hz: float | None = None,
        sonar_tilt_deg: float | None = None,
        vehicle_model: str | Path | VehicleModel | None = None,
        modem: str | Path | None = None,
        step_s: float | None = None,
    ) -> Scenario:
        """Return a validated copy with some values replaced; sonar values apply to every vehicle. Raises ScenarioError.

        vehicle_model: replaces that of the first vehicle; a packaged name, a path or the model itself. modem: the
        link's modem, as a packaged name or a path.
        """
        data = self.given()
        if seed is not None:
            data["seed"] = seed
        if step_s is not None:
            data["step_s"] = step_s
        if mission_time_s is not None:
            data["mission_time_s"] = mission_time_s
        if modem is not None:
            kept = self.link.given() if self.link else {}
            for key in ("access", "retransmissions"):
                kept.pop(key, None)
            data["link"] = {**kept, "modem": modem}
        vehicles = [vehicle.given() for vehicle in self.vehicles]
        changes: dict[str, object] = {} if sonar_tilt_deg is None else {"tilt_deg": sonar_tilt_deg}
        if sonar_model is not None or sonar_frequency_hz is not None:
            changes["frequency_hz"] = sonar_frequency_hz
            if sonar_model is not None:
                changes["model"] = sonar_model
        if changes:
            for values, vehicle in zip(vehicles, self.vehicles, strict=True):
                values["sonar"] = {**vehicle.sonar.given(), **changes}
        if vehicle_model is not None:
            vehicles[0]["model"] = vehicle_model
        data["vehicles"] = vehicles
        return validated(Scenario, data).read_from(self._source_file)
