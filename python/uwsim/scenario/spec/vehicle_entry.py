"""An entry under `vehicles:` in a scenario: a vehicle model, its start and its multibeam."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, model_validator
from pydantic_core.core_schema import ValidationInfo

from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.spec.applied_wrench import AppliedWrench
from uwsim.scenario.spec.battery import BatterySpec
from uwsim.scenario.spec.dropper import Dropper
from uwsim.scenario.spec.failsafe import Failsafe
from uwsim.scenario.spec.fields import Degrees, InRange, Model, Name, Point3, broken
from uwsim.scenario.spec.sonar_setup import SonarSetup
from uwsim.scenario.spec.tether import Tether
from uwsim.scenario.spec.vehicle import Trim, VehicleModel, VehicleName, load_vehicle


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
    model: Annotated[VehicleModel, BeforeValidator(_vehicle_model, json_schema_input_type=VehicleName | VehicleModel)]
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
