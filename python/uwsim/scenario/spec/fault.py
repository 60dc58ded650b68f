"""A scenario's faults: what fails, when, and for how long."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from uwsim.base.axes import Axis
from uwsim.scenario.spec.fields import InRange, Model, Name, Point3, broken

Share = Annotated[float, InRange(0, 1)]
Speed = Annotated[float, InRange(-5, 5, "m/s")]


class FaultModel(Model):
    """The fields common to all faults.

    name: name in the log; by default its kind, or kind_2 and so on if there are several of a kind. vehicle: name of the
    vehicle, by default the first. at_s: when it begins; either this or rate_per_h. rate_per_h: mean number of
    occurrences per hour, at random times (exponential intervals, drawn with the seed). for_s: its duration; by default
    until the end.
    """

    name: Name | None = None
    vehicle: Name | None = None
    at_s: Annotated[float, InRange(0, 1e6, "s")] | None = None
    rate_per_h: Annotated[float, InRange(1e-6, 1e5, "1/h")] | None = None
    for_s: Annotated[float, InRange(0.01, 1e6, "s")] | None = None

    @model_validator(mode="after")
    def _begins_at_some_time(self) -> FaultModel:
        if (self.at_s is None) == (self.rate_per_h is None):
            raise broken("exactly one of at_s and rate_per_h must be given")
        return self


class ThrusterFault(FaultModel):
    """A thruster produces only a fraction of its thrust; 0: none. The allocation is not aware of it.

    thruster: its name. axis: for a vehicle without thrusters, the axis on which force or torque is reduced.
    health: the fraction that remains.
    """

    kind: Literal["thruster"]
    thruster: str | None = None
    axis: Axis | None = None
    health: Share = 0.0

    @model_validator(mode="after")
    def _names_one(self) -> ThrusterFault:
        if (self.thruster is None) == (self.axis is None):
            raise broken("exactly one of thruster and axis must be given")
        return self


class SensorFault(FaultModel):
    """A sensor fails.

    sensor: its name on the vehicle. mode: `off`, no readings; `stuck`, the last reading is repeated; `bias`, a constant
    is added. bias: value added to each component of `field`, in the sensor's unit. field: field of the reading;
    required for a sensor that measures several quantities.
    """

    kind: Literal["sensor"]
    sensor: str
    mode: Literal["off", "stuck", "bias"] = "off"
    bias: Annotated[float, InRange(-1e6, 1e6)] | None = None
    field: str | None = None

    @model_validator(mode="after")
    def _has_a_bias_if_that_is_its_mode(self) -> SensorFault:
        if (self.mode == "bias") != (self.bias is not None):
            raise broken("bias must be given for `mode: bias`, and only then", at=("bias",))
        if self.field is not None and self.mode != "bias":
            raise broken("is only for `mode: bias`", at=("field",))
        return self


class SonarFault(FaultModel):
    """The multibeam receives nothing: no beam has an echo."""

    kind: Literal["sonar"]


class CameraFault(FaultModel):
    """A camera's pictures are black. camera: its name on the vehicle."""

    kind: Literal["camera"]
    camera: str


class BatteryFault(FaultModel):
    """The battery's voltage drops: all thrusters produce only a fraction of their thrust. thrust: the fraction."""

    kind: Literal["battery"]
    thrust: Share


class LeakFault(FaultModel):
    """Water enters, and remains after the leak ends; it adds weight but no buoyancy.

    kg_per_s: the inflow. kg_max: the mass at which the compartment is full. position_m: where the water collects, in
    the body frame; by default at the centre of mass.
    """

    kind: Literal["leak"]
    kg_per_s: Annotated[float, InRange(1e-6, 1000, "kg/s")]
    kg_max: Annotated[float, InRange(1e-3, 1e6, "kg")] | None = None
    position_m: Point3 | None = None


class LinkLoss(FaultModel):
    """Nothing passes between station and vehicle: commands and the vehicle's messages over the link are lost."""

    kind: Literal["link"]


class CurrentFault(FaultModel):
    """An additional current.

    velocity_world_m_s: added to water.current_world_m_s; east, north, up.
    """

    kind: Literal["current"]
    velocity_world_m_s: tuple[Speed, Speed, Speed]


FaultSpec = Annotated[
    ThrusterFault | SensorFault | SonarFault | CameraFault | BatteryFault | LeakFault | LinkLoss | CurrentFault,
    Field(discriminator="kind"),
]
