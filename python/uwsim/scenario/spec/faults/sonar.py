"""The fault `sonar`: the multibeam receives nothing."""

from __future__ import annotations

from typing import Literal

from uwsim.scenario.spec.fault import FaultModel, FaultyVehicle, Observer, Overlay


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
