"""The control station."""

from __future__ import annotations

from typing import Any

from pydantic import Field, model_validator

from uwsim.scenario.spec.camera import DECK_CAMERA, CameraMount, CameraMounts, LampSwitches, dock_camera
from uwsim.scenario.spec.fields import AssetFile, Degrees, Model, Name, Point3, broken
from uwsim.scenario.spec.material import Material, MaterialSpec


def _cameras(station: dict[str, Any]) -> dict[str, CameraMount]:
    """Return the default cameras of a station. station: the fields validated so far."""
    if station.get("carrier") is not None:
        return {}
    return {"station": dock_camera(station.get("dock_m", (0.0, 0.0, 0.0))), "deck": DECK_CAMERA}


class Station(Model):
    """The control station: distances are measured from it, and a vehicle may start docked at it.

    carrier: a vehicle on which it rides, such as a boat: position_m and yaw_deg are then in that vehicle's frame, and
    it has no mesh, cameras or lamps of its own. position_m: position of its origin, on the waterline. yaw_deg:
    direction of its x axis, counter-clockwise from east.
    mesh: mesh file, closed or not, in the station's frame; without one the station is a point. dock_m: the origin of a
    docked vehicle, in the station's frame; its heading is the station's x. exit_m: its origin after `undock()`, by
    default 3 m ahead of the dock. material: material of the mesh; without its colour, those of the file apply, if any.
    cameras: by name, in the station's frame; by default `station`, in the water in front of the dock, and `deck`,
    overlooking the deck. lamps: by name, in the station's frame; each shines throughout if it is `on`.
    """

    carrier: Name | None = None
    position_m: Point3 = (0.0, 0.0, 0.0)
    yaw_deg: Degrees = 0.0
    mesh: AssetFile | None = None
    dock_m: Point3 = (0.0, 0.0, 0.0)
    exit_m: Point3 | None = None
    material: MaterialSpec = Material.model_construct(kind="paint", colour=(0.75, 0.42, 0.07))
    cameras: CameraMounts = Field(default_factory=_cameras)
    lamps: LampSwitches = Field(default_factory=dict)

    @model_validator(mode="after")
    def _is_bare_if_carried(self) -> Station:
        for key in ("mesh", "cameras", "lamps") if self.carrier is not None else ():
            if getattr(self, key):
                raise broken("must be the vehicle's, as the station rides on it", at=(key,))
        return self
