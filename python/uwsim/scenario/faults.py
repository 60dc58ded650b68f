"""uwsim's own kinds of faults: of thrusters, instruments, battery, hull, link, water and tether."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import model_validator

from uwsim.base.axes import AXES, Axis
from uwsim.base.named import did_you_mean
from uwsim.scenario.spec.fault import FaultModel, FaultyVehicle, Observer, Overlay, PartOf, Share
from uwsim.scenario.spec.fields import InRange, Name, Point3, broken


def weaken_thruster(over: Overlay, vehicle: FaultyVehicle, thruster: str, share: float) -> None:
    """Reduce a thruster's thrust to a share of it."""
    over[f"{vehicle.name}.thrusters.{thruster}.health"] *= share


def weaken_axis(over: Overlay, vehicle: FaultyVehicle, axis: int, share: float) -> None:
    """Reduce the maximum force or torque on one axis of a vehicle without thrusters."""
    key = "max_force_n" if axis < 3 else "max_torque_nm"
    over[f"{vehicle.name}.{key}.{'xyz'[axis % 3]}"] *= share


class ThrusterFault(FaultModel):
    """A thruster produces only a fraction of its thrust; 0: none. The allocation is not aware of it.

    thruster: its name. axis: for a vehicle without thrusters, the axis on which force or torque is reduced.
    health: the fraction that remains.
    """

    kind: Literal["thruster"]
    thruster: Annotated[str | None, PartOf("thrusters")] = None
    axis: Axis | None = None
    health: Share = 0.0

    @model_validator(mode="after")
    def _names_one(self) -> ThrusterFault:
        if (self.thruster is None) == (self.axis is None):
            raise broken("exactly one of thruster and axis must be given")
        return self

    def check(self, vehicle: FaultyVehicle) -> None:
        """See FaultModel."""
        thrusters = vehicle.model.thrusters
        if self.axis is not None and thrusters:
            raise ValueError(f"axis: vehicle '{vehicle.name}' has thrusters: {', '.join(thrusters)}; name one of them")
        if self.thruster is not None and not thrusters:
            rule = f"vehicle '{vehicle.name}' has no thrusters; give an axis: {', '.join(AXES)}"
            raise ValueError(f"thruster = {self.thruster!r}: {rule}")
        super().check(vehicle)

    def apply(self, over: Overlay, vehicle: FaultyVehicle, water_kg: float) -> None:
        """See FaultModel."""
        if self.thruster is not None:
            weaken_thruster(over, vehicle, self.thruster, self.health)
        else:
            weaken_axis(over, vehicle, AXES.index(str(self.axis)), self.health)


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


class SonarFault(FaultModel):
    """The multibeam receives nothing: no beam has an echo."""

    kind: Literal["sonar"]

    def check(self, vehicle: FaultyVehicle) -> None:
        """See FaultModel."""
        if not vehicle.sonars:
            raise ValueError(f"kind = 'sonar': vehicle '{vehicle.name}' carries no multibeam")

    def apply(self, over: Overlay, vehicle: FaultyVehicle, water_kg: float) -> None:
        """See FaultModel."""
        over[f"{vehicle.name}.sonar.on"] = False

    def unnoticed(self, observer: Observer) -> str:
        """See FaultModel."""
        return "" if observer.pings else f"{observer.name} uses no sonar"


class CameraFault(FaultModel):
    """A camera's pictures are black. camera: its name on the vehicle."""

    kind: Literal["camera"]
    camera: Annotated[str, PartOf("cameras")]

    def apply(self, over: Overlay, vehicle: FaultyVehicle, water_kg: float) -> None:
        """See FaultModel."""
        over[f"{vehicle.name}.cameras.{self.camera}.on"] = False

    def unnoticed(self, observer: Observer) -> str:
        """See FaultModel."""
        return "" if self.camera == observer.camera else f"camera '{self.camera}': is not observed"


class BatteryFault(FaultModel):
    """The battery's voltage drops: all thrusters produce only a fraction of their thrust. thrust: the fraction."""

    kind: Literal["battery"]
    thrust: Share

    def apply(self, over: Overlay, vehicle: FaultyVehicle, water_kg: float) -> None:
        """See FaultModel."""
        for thruster in vehicle.model.thrusters:
            weaken_thruster(over, vehicle, thruster, self.thrust)
        for axis in range(6) if not vehicle.model.thrusters else ():
            weaken_axis(over, vehicle, axis, self.thrust)


class LeakFault(FaultModel):
    """Water enters, and remains after the leak ends; it adds weight but no buoyancy.

    kg_per_s: the inflow. kg_max: the mass at which the compartment is full. position_m: where the water collects, in
    the body frame; by default at the centre of mass.
    """

    kind: Literal["leak"]
    kg_per_s: Annotated[float, InRange(1e-6, 1000, "kg/s")]
    kg_max: Annotated[float, InRange(1e-3, 1e6, "kg")] | None = None
    position_m: Point3 | None = None

    def water_kg_after(self, water_kg: float, steps: int, step_s: float) -> float:
        """See FaultModel."""
        return min(water_kg + self.kg_per_s * steps * step_s, self.kg_max or math.inf)

    def apply(self, over: Overlay, vehicle: FaultyVehicle, water_kg: float) -> None:
        """Add the water as ballast (weight and inertia, no buoyancy), merged with other ballast at their centre."""
        if water_kg <= 0.0:
            return
        mass, place = f"{vehicle.name}.ballast_kg", f"{vehicle.name}.ballast_position_m"
        at_m = self.position_m or vehicle.model.centre_of_mass_m
        before_kg = over[mass]
        over[mass] = total_kg = before_kg + water_kg
        for k, key in enumerate("xyz"):
            over[f"{place}.{key}"] = (before_kg * over[f"{place}.{key}"] + water_kg * at_m[k]) / total_kg


class LinkLoss(FaultModel):
    """Nothing passes between station and vehicle: commands and the vehicle's messages over the link are lost."""

    kind: Literal["link"]

    cuts_link = True

    def unnoticed(self, observer: Observer) -> str:
        """See FaultModel."""
        return "" if observer.has_link else "the scenario has no link"


FASTEST_M_S = 5.0  # limit on the components of a velocity, as in scenarios
Speed = Annotated[float, InRange(-FASTEST_M_S, FASTEST_M_S, "m/s")]


class CurrentFault(FaultModel):
    """An additional current.

    velocity_world_m_s: added to water.current_world_m_s; east, north, up.
    """

    kind: Literal["current"]
    velocity_world_m_s: tuple[Speed, Speed, Speed]

    def apply(self, over: Overlay, vehicle: FaultyVehicle, water_kg: float) -> None:
        """See FaultModel."""
        for key, speed in zip("xyz", self.velocity_world_m_s, strict=True):
            name = f"water.current_world_m_s.{key}"
            over[name] = min(max(over[name] + speed, -FASTEST_M_S), FASTEST_M_S)


class TetherFault(FaultModel):
    """The vehicle's tether breaks at once, or, with breaking_load_n, is damaged and breaks under a smaller load.

    A broken tether remains broken. object: the loose body whose tether it is instead. at_m: the length from its anchor
    at which it breaks; by default, and if less than that is out, at its other end. breaking_load_n: while the fault
    lasts, it breaks where the tension exceeds this.
    """

    kind: Literal["tether"]
    object: Name | None = None
    at_m: Annotated[float, InRange(0, 20_000, "m")] | None = None
    breaking_load_n: Annotated[float, InRange(0.1, 1e9, "N")] | None = None

    @model_validator(mode="after")
    def _breaks_at_once_or_under_load(self) -> TetherFault:
        if self.at_m is not None and self.breaking_load_n is not None:
            raise broken("must not be given with breaking_load_n: the load decides where it breaks", at=("at_m",))
        return self

    def check(self, vehicle: FaultyVehicle) -> None:
        """See FaultModel."""
        if self.object is None and vehicle.name not in vehicle.tethers:
            raise ValueError(f"kind = 'tether': vehicle '{vehicle.name}' has no tether")
        if self.object is not None and self.object not in vehicle.tethers:
            known = list(vehicle.tethers)
            rule = f"must be one with a tether, {', '.join(known) or 'of which there is none'}"
            raise ValueError(f"object = {self.object!r}: {rule}{did_you_mean(self.object, known)}")

    def begin(self, vehicle: FaultyVehicle) -> None:
        """See FaultModel."""
        if self.breaking_load_n is None:
            tether = vehicle.tethers[self.object or vehicle.name]
            out_m = tether.length_m
            tether.cut(out_m if self.at_m is None else min(self.at_m, out_m))

    def tether_bears_n(self, of: str, vehicle: str) -> float:
        """See FaultModel."""
        return math.inf if self.breaking_load_n is None or of != (self.object or vehicle) else self.breaking_load_n
