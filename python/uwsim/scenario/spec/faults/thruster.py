"""The fault `thruster`: one thruster is weak, or out."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import model_validator

from uwsim.base.axes import AXES, Axis
from uwsim.scenario.spec.fault import FaultModel, FaultyVehicle, Overlay, PartOf, Share
from uwsim.scenario.spec.faults.weaken import weaken_axis, weaken_thruster
from uwsim.scenario.spec.fields import broken


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
