"""The fault `battery`: the supply fails partially."""

from __future__ import annotations

from typing import Literal

from uwsim.scenario.spec.fault import FaultModel, FaultyVehicle, Overlay, Share
from uwsim.scenario.spec.faults.weaken import weaken_axis, weaken_thruster


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
