"""An entry under `vehicles:` in a scenario: a vehicle model, its start and its multibeam."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import BeforeValidator, Field, PlainSerializer, PlainValidator, StrictBool, model_validator
from pydantic_core.core_schema import ValidationInfo

from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.arm import Dropper
from uwsim.scenario.spec.battery import BatterySpec, Failsafe
from uwsim.scenario.spec.fields import AssetName, Degrees, InRange, Model, Name, NoseDown, Point3, broken
from uwsim.scenario.spec.loose_body import AppliedWrench
from uwsim.scenario.spec.sonar import (
    WIRE_NUMBERS,
    FrequencyHz,
    Receivers,
    SonarMode,
    SonarModel,
    SonarNoise,
    SonarNoiseChanges,
    load_sonar,
)
from uwsim.scenario.spec.tether import Tether
from uwsim.scenario.spec.vehicle import Trim, VehicleModel, VehicleName, load_vehicle

SonarNumber = Annotated[int, InRange(*WIRE_NUMBERS)]
SonarName = Annotated[str, AssetName("sonars")]


def _sonar_model(value: object, info: ValidationInfo) -> object:
    folder = (info.context or {}).get("folder")
    if isinstance(value, str | Path):
        return load_sonar(value, folder=folder)
    if isinstance(value, Mapping):
        return validated(SonarModel, value, folder=folder)
    if isinstance(value, SonarModel):
        return value
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | np.integer):
        raise broken("must be a whole number, a model's name or the path of its file, or the model itself")
    low, high = WIRE_NUMBERS
    if not low <= value <= high:
        raise broken(f"must be in [{low}, {high}]")
    return int(value)


def _dumped(model: int | SonarModel) -> object:
    return model.model_dump() if isinstance(model, SonarModel) else model


def _given_figures(value: object) -> object:
    return value.given() if isinstance(value, SonarNoise) else value


class SonarSetup(Model):
    """A vehicle's multibeam model, and how it is simulated.

    model: an EM 2040 by its number on the wire (1: 600 kHz single, 2: 700 kHz single, 3: 600 kHz dual, 4: 700 kHz dual
    swath); or a packaged model's name, or the path of its YAML file, which is read into a SonarModel. frequency_hz:
    frequency, for a model with several. range_max_m: the operator's setting, for a model with a larger range; the
    travel time over this range then limits the ping rate. receivers: 2 ("dual RX") for a model that can have two, with
    a wider fan and twice the beams; by default the model's number. mode: `geometry`, one exact ray for each beam, or
    `physics`, in which ranges, errors and gaps follow from acoustics. bending: in physics mode, rays follow the water's
    sound-speed profile. rays_per_beam: number of rays for each footprint, in physics mode. multipath: in physics mode,
    whether echoes by more than one bounce are received; by default the model's. water_column: in physics mode, whether
    every ping contains the water column, and whether a channel provides it. tilt_rate_deg_s: tilt rate of the head,
    overriding the model's. gain_db: gain of the receiver's display, added to every intensity. noise: values for physics
    mode that override the model's.
    tilt_deg: initial tilt, positive nose down, as scanPos on the wire. on: a sonar that is off tilts, but receives no
    echoes.
    """

    model: Annotated[
        int | SonarModel,
        PlainValidator(_sonar_model, json_schema_input_type=SonarNumber | SonarName | SonarModel),
        PlainSerializer(_dumped),
    ] = 2
    frequency_hz: FrequencyHz | None = None
    range_max_m: Annotated[float, InRange(0.1, 12_000, "m")] | None = None
    receivers: Receivers | None = None
    mode: SonarMode = "geometry"
    bending: bool = False
    rays_per_beam: Annotated[int, InRange(4, 64)] = 8
    multipath: StrictBool | None = None
    water_column: StrictBool = False
    tilt_rate_deg_s: Annotated[float, InRange(0.01, 1000, "deg/s")] | None = None
    gain_db: Annotated[float, InRange(-100, 100, "dB")] = 0.0
    noise: Annotated[SonarNoiseChanges, BeforeValidator(_given_figures)] | None = None
    tilt_deg: NoseDown = 0.0
    on: StrictBool = True

    @model_validator(mode="after")
    def _fits_its_model(self) -> SonarSetup:
        for key in ("bending", "multipath", "water_column"):
            if getattr(self, key) and self.mode != "physics":
                raise broken("is for `mode: physics` only", at=(key,), value=True)
        try:
            loaded = self.loaded
            if self.mode == "physics":
                loaded.acoustic_band(self.frequency_hz)
            else:
                loaded.band(self.frequency_hz)
        except ScenarioError:
            raise
        except ValueError as error:
            raise broken(str(error)) from None
        if self.range_max_m is not None and loaded.wire_number is not None:
            fixed = f"must be left out for {self.loaded.name}, whose range is fixed"
            rule = f"{fixed}; it is for models such as em2040-04 and em2040-07"
            raise broken(rule, at=("range_max_m",), value=self.range_max_m, unit="m")
        return self

    @property
    def loaded(self) -> SonarModel:
        """The model with the selected receivers, range, tilt rate and noise. Raises ValueError."""
        model = self.model if isinstance(self.model, SonarModel) else load_sonar(self.model)
        if self.receivers is not None:
            model = model.with_receivers(self.receivers, self.frequency_hz)
        own: dict[str, object] = {}
        if self.multipath is not None:
            own["multipath"] = self.multipath
        if self.tilt_rate_deg_s is not None:
            own["tilt_rate_deg_s"] = self.tilt_rate_deg_s
        if self.noise is not None:
            own["noise"] = self.noise.of(model.noise)
        model = model.model_copy(update=own) if own else model
        return model if self.range_max_m is None else model.within(self.range_max_m)

    @property
    def title(self) -> str:
        """The wire number or name of the model, with the receivers and the frequency if specified."""
        name = self.model.name if isinstance(self.model, SonarModel) else str(self.model)
        name = f"{name} with {self.receivers} receivers" if self.receivers is not None else name
        return name if self.frequency_hz is None else f"{name} at {self.frequency_hz / 1e3:g} kHz"


class StartPose(Model):
    """A free start, level and at rest.

    position_m: the vehicle's origin in the world. yaw_deg: direction of its x axis, counter-clockwise from east.
    """

    position_m: Point3
    yaw_deg: Degrees = 0.0


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


class VehicleEntry(Model):
    """One vehicle in the scenario.

    sonar: its multibeam, on the model's mount. model: the name of a packaged vehicle or the path of its YAML file,
    which is read into a VehicleModel. failsafe, trim: override the model's. start: `station` (docked there; None in
    Python) or a free pose. battery: a battery of cells, which the thrusters drain; by default the scenario's
    mission_time_s. command_timeout_s: the simulated time after which it stops if a publisher of steering commands, such
    as /cmd_vel, falls silent; 0: the last command is held. Commands by services, Python and the published topic `key`
    are held in any case. xy_goal_tolerance: the distance from a target that a program sends, also in depth, at which
    it counts as reached, by Nav2's name; at least 0.5 m for a vehicle that cannot stand still. yaw_goal_tolerance: the
    same for its heading. wrenches: what pushes it from outside, by schedule. tether: by default none. droppers:
    of markers and torpedoes, by name.
    """

    name: Name
    model: Annotated[
        VehicleModel, BeforeValidator(_vehicle_model, json_schema_input_type=VehicleName | VehicleModel)
    ] = Field(examples=["bluerov2_heavy_outfit"])
    start: Annotated[
        StartPose | None, BeforeValidator(_start, json_schema_input_type=Literal["station"] | StartPose)
    ] = None
    sonar: SonarSetup = SonarSetup.model_construct()
    failsafe: Failsafe | None = None
    trim: Trim | None = None
    command_timeout_s: Annotated[float, InRange(0, 1e6, "s")] = 0.5
    xy_goal_tolerance: Annotated[float, InRange(0.01, 100, "m")] = 0.1
    yaw_goal_tolerance: Annotated[float, InRange(0.01, 3.15, "rad")] = 0.05
    battery: BatterySpec | None = None
    wrenches: Annotated[tuple[AppliedWrench, ...], Field(max_length=1000)] = ()
    tether: Tether | None = None
    droppers: Annotated[dict[Name, Dropper], Field(max_length=16)] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _has_thrusters_for_its_battery(self) -> VehicleEntry:
        if self.battery is None:
            return self
        if not self.model.thrusters:
            raise broken("the vehicle has no thrusters to supply: use mission_time_s", at=("battery",))
        low_v, high_v = self.battery.model.cutoff_v, self.battery.model.open_circuit_v[-1][1]
        first: list[float] | None = None
        for name, mount in self.model.thrusters.items():
            try:
                volts = mount.model.performance().voltages_v
            except ScenarioError as error:
                raise broken(f"thruster '{name}': {error}", at=("battery",)) from None
            if not volts[0] <= low_v < high_v <= volts[-1]:
                rule = f"its voltages, {low_v:g} to {high_v:g} V, must lie within those of thruster '{name}', "
                raise broken(f"{rule}{volts[0]:g} to {volts[-1]:g} V", at=("battery",))
            if first is not None and volts != first:
                raise broken("the sheets of all thrusters must be of the same voltages", at=("battery",))
            first = volts
        return self
