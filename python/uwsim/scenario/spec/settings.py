"""The small sections of a scenario: engine, place on Earth, view, warnings, and the control station."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from uwsim.scenario.spec.camera import DECK_CAMERA, CameraMount, CameraMounts, LampSwitches, dock_camera
from uwsim.scenario.spec.fields import AssetFile, Degrees, InRange, Model, Name, NoseDown, Point3, broken
from uwsim.scenario.spec.material import Material, MaterialSpec


class Dynamics(Model):
    """The engine that moves the vehicles.

    engine: `uwsim` integrates with the full mass matrix and solves contacts with it; `bullet` is Bullet's own dynamics,
    with the added mass folded into mass and inertia.
    """

    engine: Literal["uwsim", "bullet"] = "uwsim"


class Earth(Model):
    """The location of the world's origin on Earth, where x points to the east and y to true north (WGS 84).

    Elsewhere, x and y are those of the transverse Mercator projection about the origin.
    latitude_deg: geodetic latitude, north positive, which decides gravity, too (WGS 84). longitude_deg: longitude, east
    positive. magnetic_year: the year (2026.5 is its middle) of the World Magnetic Model whose field at the origin all
    compasses measure, except what their own declination_deg, inclination_deg and field_ut give; by default, only these
    and their defaults count.
    """

    latitude_deg: Annotated[float, InRange(-89, 89, "deg")]
    longitude_deg: Annotated[float, InRange(-180, 180, "deg")]
    magnetic_year: Annotated[float, InRange(2020, 2030, "yr")] | None = None


class View(Model):
    """A pose of the first vehicle from which its cameras show what the scenario is about. No flight uses it.

    position_m: of the vehicle. yaw_deg: its heading, counter-clockwise from east. pitch_deg: positive nose down.
    """

    position_m: Point3
    yaw_deg: Degrees = 0.0
    pitch_deg: NoseDown = 0.0


class WarningLimits(Model):
    """Limits beyond which the panel issues warnings.

    range_m: largest distance from the station. proximity_m: smallest height above the bed.
    """

    range_m: Annotated[float, InRange(0, 1e5, "m")] = 110.0
    proximity_m: Annotated[float, InRange(0, 1e3, "m")] = 10.0


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
