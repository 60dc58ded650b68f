"""The fault `sensor`: a sensor is silent, repeats itself, or is wrong by a constant."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import model_validator

from uwsim.scenario.spec.fault import FaultModel, FaultyVehicle, Observer, Overlay, PartOf
from uwsim.scenario.spec.fields import InRange, broken


class SensorFault(FaultModel):
    """A sensor fails.

    sensor: its name on the vehicle. mode: `off`, no readings; `stuck`, the last reading is repeated; `bias`, a constant
    is added. bias: value added to each component of `field`, in the sensor's unit. field: field of the reading;
    required for a sensor that measures several quantities.
    """

    kind: Literal["sensor"]
    sensor: Annotated[str, PartOf("sensors")]
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

    def check(self, vehicle: FaultyVehicle) -> None:
        """See FaultModel."""
        super().check(vehicle)
        fields = vehicle.sensors[self.sensor].unit
        if self.mode != "bias":
            return
        if isinstance(fields, dict):
            biasable = [name for name in fields if name != "orientation_xyzw"]
            if self.field not in biasable:
                raise ValueError(f"field = {self.field!r}: must be one of {', '.join(biasable)}")
        elif self.field is not None:
            raise ValueError(f"field = {self.field!r}: sensor '{self.sensor}' has one quantity; leave it out")

    def begin(self, vehicle: FaultyVehicle) -> None:
        """See FaultModel."""
        if self.mode == "stuck":
            vehicle.sensors[self.sensor].stick()
        elif self.mode == "bias":
            vehicle.sensors[self.sensor].add_bias(float(self.bias or 0.0), self.field)

    def end(self, vehicle: FaultyVehicle) -> None:
        """See FaultModel."""
        vehicle.sensors[self.sensor].distort(None)

    def apply(self, over: Overlay, vehicle: FaultyVehicle, water_kg: float) -> None:
        """See FaultModel."""
        if self.mode == "off":
            over[f"{vehicle.name}.sensors.{self.sensor}.on"] = False

    def unnoticed(self, observer: Observer) -> str:
        """See FaultModel."""
        if self.sensor in observer.sensors or observer.watches_sensors:
            return ""
        return f"sensor '{self.sensor}': {observer.name} reads {', '.join(observer.sensors) or 'none'}"
