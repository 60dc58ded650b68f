"""An entry of a scenario's `vehicles:`: a vehicle model, its start and its multibeam."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import BeforeValidator
from pydantic_core.core_schema import ValidationInfo

from uwsim.scenario.spec.failsafe import Failsafe
from uwsim.scenario.spec.fields import AssetName, Degrees, InRange, Model, Name, Point3, broken
from uwsim.scenario.spec.sonar_setup import SonarSetup
from uwsim.scenario.spec.vehicle import Trim, VehicleModel, load_vehicle

VehicleName = Annotated[str, AssetName("vehicles")]


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
    Python) or a free pose. command_timeout_s: the simulated time after which it stops if a publisher of steering
    commands, such as /cmd_vel, falls silent; 0: the last command is held. Commands by services, Python and the
    published topic `key` are held in any case.
    """

    name: Name
    model: Annotated[VehicleModel, BeforeValidator(_vehicle_model, json_schema_input_type=VehicleName | VehicleModel)]
    start: Annotated[
        StartPose | None, BeforeValidator(_start, json_schema_input_type=Literal["station"] | StartPose)
    ] = None
    sonar: SonarSetup = SonarSetup()
    failsafe: Failsafe | None = None
    trim: Trim | None = None
    command_timeout_s: Annotated[float, InRange(0, 1e6, "s")] = 0.5
