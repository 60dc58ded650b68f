"""The fault `kelp`: the vehicle drags weeds along."""

from __future__ import annotations

from typing import Annotated, Literal

from uwsim.base.axes import AXES
from uwsim.scenario.spec.fault import FaultModel, FaultyVehicle, Overlay
from uwsim.scenario.spec.fields import InRange


class Kelp(FaultModel):
    """Kelp clings to the hull and multiplies its drag.

    times: the factor of the quadratic drag on all axes.
    """

    kind: Literal["kelp"]
    times: Annotated[float, InRange(1, 100)] = 2.0

    def apply(self, over: Overlay, vehicle: FaultyVehicle, water_kg: float) -> None:
        """Multiply the drag, on top of earlier faults."""
        for axis in AXES:
            over[f"{vehicle.name}.drag.quadratic.{axis}"] *= self.times
