"""The fault `camera`: a camera's pictures are black."""

from __future__ import annotations

from typing import Annotated, Literal

from uwsim.scenario.spec.fault import FaultModel, FaultyVehicle, Observer, Overlay, PartOf


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
