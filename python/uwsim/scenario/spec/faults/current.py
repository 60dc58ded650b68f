"""The fault `current`: the water moves differently."""

from __future__ import annotations

from typing import Annotated, Literal

from uwsim.scenario.spec.fault import FaultModel, FaultyVehicle, Overlay
from uwsim.scenario.spec.fields import InRange

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
