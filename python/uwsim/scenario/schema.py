"""A scenario: the place, the things in it, the vehicles and what they are sent to do."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import BeforeValidator, Field, PlainSerializer, PlainValidator, PrivateAttr, model_validator
from pydantic_core.core_schema import ValidationInfo

from uwsim.scenario.camera_spec import STATION_CAMERA, CameraMounts
from uwsim.scenario.errors import ScenarioError
from uwsim.scenario.fields import (
    AssetFile,
    Degrees,
    InRange,
    Model,
    Name,
    Point2,
    Point3,
    broken,
)
from uwsim.scenario.material_spec import Ground, Material, MaterialSpec
from uwsim.scenario.messages import validated
from uwsim.scenario.obstacle_spec import ObstacleSpec
from uwsim.scenario.optics_spec import Optics
from uwsim.scenario.origin import Origin
from uwsim.scenario.polygon import area, crossing_edges, narrowest_width
from uwsim.scenario.sonar_spec import WIRE_NUMBERS, FrequencyKhz, SonarMode, SonarModel, load_sonar
from uwsim.scenario.terrain_spec import TerrainSpec
from uwsim.scenario.vehicle_model import VehicleModel
from uwsim.scenario.vehicles import load_vehicle
from uwsim.scenario.water_spec import Water

NoseDown = Annotated[float, InRange(-90, 90, "deg")]
RESERVED_NAMES = ("nothing", "terrain", "station")
LEAST_WIDTH_VOXELS, LEAST_AREA_VOXELS = 2, 10
"""Of a survey: anything smaller is no area on the map."""


class Station(Model):
    """The control station, from which distances are taken and where a vehicle may start docked.

    position_m: of its own origin, on the water line. yaw_deg: of its x axis from east, counter-clockwise.
    mesh: closed or not, in the station's frame; without one the station is a point. dock_m: where a docked
    vehicle's origin is held, in the station's frame; the vehicle looks along the station's x. cameras: by name, in the
    station's frame.
    """

    position_m: Point3
    yaw_deg: Degrees = 0.0
    mesh: AssetFile | None = None
    dock_m: Point3 = (0.0, 0.0, 0.0)
    material: MaterialSpec = Material(kind="paint", colour=(0.75, 0.42, 0.07))
    cameras: CameraMounts = Field(default_factory=lambda: {"station": STATION_CAMERA})


class StartPose(Model):
    """A free start, level, at position_m (world)."""

    position_m: Point3
    yaw_deg: Degrees = 0.0


def _sonar_model(value: object, info: ValidationInfo) -> object:
    if isinstance(value, str | Path):
        return load_sonar(value, folder=(info.context or {}).get("folder"))
    if isinstance(value, SonarModel):
        return value
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | np.integer):
        raise broken("must be a whole number, or a model's name or the path of its file")
    low, high = WIRE_NUMBERS
    if not low <= value <= high:
        raise broken(f"must be in [{low}, {high}]")
    return int(value)


def _dumped(model: int | SonarModel) -> object:
    return model.model_dump() if isinstance(model, SonarModel) else model


class Sonar(Model):
    """Which multibeam the vehicle carries, and how it is simulated.

    model: an EM 2040 by its number on the wire (1: 600 kHz single, 2: 700 kHz single, 3: 600 kHz dual, 4: 700 kHz dual
    swath); or a packaged model's name, or the path of its YAML file, held here as the model that was read.
    frequency_khz: of a model that works at several. range_m: what the operator sets, where the model reaches farther:
    pings follow one another as fast as sound comes back from there. mode: `geometry`, one exact ray a beam, or
    `physics`, whose ranges, errors and gaps come from its acoustics. bending: physics mode's rays follow the water's
    speed of sound. tilt_deg: at the start, positive nose down, as on the wire's scanPos.
    """

    model: Annotated[int | SonarModel, PlainValidator(_sonar_model), PlainSerializer(_dumped)] = 2
    frequency_khz: FrequencyKhz | None = None
    range_m: Annotated[float, InRange(0.1, 12_000, "m")] | None = None
    mode: SonarMode = "geometry"
    bending: bool = False
    rays_per_beam: Annotated[int, InRange(4, 64)] = 8
    tilt_deg: NoseDown = 0.0

    @model_validator(mode="after")
    def _fits_its_model(self) -> Sonar:
        if self.range_m is not None and self.loaded.wire_number is not None:
            rule = "is for instruments that are not on the wire: the published one's range is its model's"
            raise broken(rule, at=("range_m",), value=self.range_m, unit="m")
        if self.bending and self.mode != "physics":
            raise broken("is for `mode: physics` only", at=("bending",), value=self.bending)
        try:
            self.loaded.core_model(self.frequency_khz)
            if self.mode == "physics":
                self.loaded.core_acoustics(self.frequency_khz)
        except ScenarioError:
            raise
        except ValueError as error:
            raise broken(str(error)) from None
        return self

    @property
    def loaded(self) -> SonarModel:
        """The model itself."""
        model = self.model if isinstance(self.model, SonarModel) else load_sonar(self.model)
        return model if self.range_m is None else model.within(self.range_m)

    @property
    def title(self) -> str:
        """The model's number on the wire, or its name; and the frequency where it was chosen."""
        name = self.model.name if isinstance(self.model, SonarModel) else str(self.model)
        return name if self.frequency_khz is None else f"{name} at {self.frequency_khz:g} kHz"


def _start(value: object) -> object:
    if isinstance(value, str):
        if value != "station":
            raise broken("must be 'station', or position_m and yaw_deg")
        return None
    return value


def _vehicle_model(value: object, info: ValidationInfo) -> object:
    if isinstance(value, str | Path):
        return load_vehicle(value, folder=(info.context or {}).get("folder"))
    return value


class Vehicle(Model):
    """One vehicle in the scenario.

    model: a packaged vehicle's name or the path of its YAML file; held here as the model that was read.
    start: `station` (docked there; None in Python) or a free pose.
    """

    name: Name
    model: Annotated[VehicleModel, BeforeValidator(_vehicle_model)]
    start: Annotated[StartPose | None, BeforeValidator(_start)] = None
    sonar: Sonar = Sonar()


class Warnings(Model):
    """When the panel warns: farther than range_m from the station, lower than proximity_m above the bed."""

    range_m: Annotated[float, InRange(0, 1e5, "m")] = 110.0
    proximity_m: Annotated[float, InRange(0, 1e3, "m")] = 10.0


class Survey(Model):
    """What `uwsim survey` flies here.

    area_m: corners (x, y) of the polygon to cover, in order round it. altitude_m: above the bed. line_spacing_m: of
    the lawn-mower's lines. speed_m_s: along them. tilt_deg: of the sonar, positive nose down. voxel_m: of the map.
    """

    area_m: Annotated[tuple[Point2, ...], Field(min_length=3, max_length=100)]
    altitude_m: Annotated[float, InRange(0.5, 500, "m")]
    line_spacing_m: Annotated[float, InRange(0.5, 500, "m")]
    speed_m_s: Annotated[float, InRange(0.05, 5, "m/s")]
    tilt_deg: NoseDown = 30.0
    ping_rate_hz: Annotated[float, InRange(0.1, 50, "Hz")] = 10.0
    voxel_m: Annotated[float, InRange(0.02, 10, "m")] = 0.5

    @model_validator(mode="after")
    def _is_a_polygon(self) -> Survey:
        crossing = crossing_edges(self.area_m)
        if crossing is not None:
            raise broken(f"the edges that start at its corners {crossing[0]} and {crossing[1]} meet", at=("area_m",))
        width, least = narrowest_width(self.area_m), LEAST_WIDTH_VOXELS * self.voxel_m
        if width < least:
            rule = f"is {width:.3g} m across where it is narrowest: must be at least {LEAST_WIDTH_VOXELS} voxels"
            raise broken(f"{rule}, {least:g} m", at=("area_m",))
        size, least = area(self.area_m), LEAST_AREA_VOXELS * self.voxel_m**2
        if size < least:
            rule = f"covers {size:.3g} m2: must be at least {LEAST_AREA_VOXELS} voxels, {least:g} m2"
            raise broken(rule, at=("area_m",))
        return self


class Scenario(Model):
    """All that fixes a run, the number of threads excepted. World ENU, z up, water surface at z = 0."""

    name: Name
    description: str = ""
    seed: Annotated[int, InRange(0, 2**63 - 1)] = 0
    step_s: Annotated[float, InRange(0.0005, 0.02, "s")] = 0.005
    mission_time_s: Annotated[float, InRange(1, 1e6, "s")] = 3600.0
    water: Water = Water()
    optics: Optics = Optics()
    terrain: TerrainSpec
    ground: Ground = Ground()
    obstacles: Annotated[tuple[ObstacleSpec, ...], Field(max_length=10_000)] = ()
    station: Station
    vehicles: Annotated[tuple[Vehicle, ...], Field(min_length=1, max_length=64)]
    warnings: Warnings = Warnings()
    survey: Survey | None = None

    _origin: Origin = PrivateAttr(default=Origin())

    @model_validator(mode="after")
    def _names_are_unique(self) -> Scenario:
        taken = set(RESERVED_NAMES)
        for kind, items in (("obstacles", self.obstacles), ("vehicles", self.vehicles)):
            for index, item in enumerate(items):
                if item.name in taken:
                    raise broken("is taken", at=(kind, index, "name"), value=item.name)
                taken.add(item.name)
        return self

    @model_validator(mode="after")
    def _one_at_a_time_is_docked(self) -> Scenario:
        docked = [index for index, vehicle in enumerate(self.vehicles) if vehicle.start is None]
        if len(docked) > 1:
            rule = "the dock holds one vehicle; give this one a position_m"
            raise broken(rule, at=("vehicles", docked[1], "start"), value="station")
        return self

    @property
    def origin(self) -> Origin:
        """The file it was read from, for messages."""
        return self._origin

    def read_from(self, origin: Origin) -> Self:
        """Return the same scenario, which knows its file."""
        copy = super().model_copy()
        copy._origin = origin
        return copy

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """As pydantic's; a copy with updates is no longer what the file says."""
        copy = super().model_copy(update=update, deep=deep)
        return copy.read_from(Origin()) if update else copy

    def with_changes(
        self,
        *,
        seed: int | None = None,
        mission_time_s: float | None = None,
        sonar_model: int | str | Path | None = None,
        sonar_frequency_khz: float | None = None,
    ) -> Scenario:
        """Copy with some figures replaced and checked; the sonar's are those of every vehicle. Raises ScenarioError."""
        data: dict[str, Any] = {key: getattr(self, key) for key in type(self).model_fields}
        if seed is not None:
            data["seed"] = seed
        if mission_time_s is not None:
            data["mission_time_s"] = mission_time_s
        if sonar_model is not None or sonar_frequency_khz is not None:
            another: dict[str, object] = {"frequency_khz": sonar_frequency_khz}
            if sonar_model is not None:
                another["model"] = sonar_model
            data["vehicles"] = [
                {**dict(vehicle), "sonar": {**dict(vehicle.sonar), **another}} for vehicle in self.vehicles
            ]
        return validated(Scenario, data).read_from(self._origin)
