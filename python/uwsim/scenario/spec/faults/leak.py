"""The fault `leak`: water enters the hull."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from uwsim.scenario.spec.fault import FaultModel, FaultyVehicle, Overlay
from uwsim.scenario.spec.fields import InRange, Point3


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
