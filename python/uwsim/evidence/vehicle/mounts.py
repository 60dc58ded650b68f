"""The mounts of a vehicle's parts: how far they are from the hull, and whether the hull blocks their beams."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import ConvexHull

from uwsim import _core
from uwsim.base.quaternions import of_yaw_pitch_roll_deg, turned
from uwsim.scenario.build.hull import hull_scene, vehicle_hull
from uwsim.scenario.spec.imaging_kind import core_kind, imaging_kind
from uwsim.scenario.spec.sensor import SensorMount
from uwsim.scenario.spec.vehicle import VehicleModel

Floats = NDArray[np.float64]
AHEAD, DOWN = (1.0, 0.0, 0.0), (0.0, 0.0, -1.0)
DVL_BEAMS = 4
SKIN_M, FAR_M = 1e-3, 1e3
"""Surfaces closer to an instrument than this belong to the skin in which the instrument is mounted."""


@dataclass(frozen=True)
class Mount:
    """A part fixed to the hull.

    key: its key in the model's file, such as "sensors". name: its name there; empty for a single part. away_m: distance
    from the hull's bounding box; 0 inside. off_down_deg: angle between a DVL's axis and straight down on a level
    vehicle; None for other parts. beams_in_hull: share of its beams or lines of sight that enter the hull from outside;
    0 for parts without beams, and for parts within an open frame, whose members the beams may miss.
    """

    key: str
    name: str
    position_m: tuple[float, float, float]
    away_m: float
    off_down_deg: float | None = None
    beams_in_hull: float = 0.0

    @property
    def label(self) -> str:
        """The part's key in the file, such as `sensors.dvl`."""
        return f"{self.key}.{self.name}" if self.name else self.key


def mounts(model: VehicleModel) -> tuple[Mount, ...]:
    """Return all mounts of a model. Raises ScenarioError if its mesh is not a valid hull."""
    vertices, triangles = vehicle_hull(model)
    hull, sides = hull_scene(vertices, triangles), ConvexHull(vertices).equations
    return tuple(_mount(hull, vertices, sides, *each) for each in _mounted(model))


def _mount(
    hull: _core.RayScene,
    vertices_m: Floats,
    sides: Floats,
    key: str,
    name: str,
    position_m: ArrayLike,
    beams: Floats,
    is_dvl: bool,
) -> Mount:
    """Return one mount. vertices_m: (n, 3), the hull's vertices. sides: (k, 4), planes of its convex hull."""
    at = np.asarray(position_m, np.float64)
    outside = np.maximum(0.0, np.maximum(vertices_m.min(axis=0) - at, at - vertices_m.max(axis=0)))
    is_within = bool(np.all(sides[:, :3] @ at + sides[:, 3] <= SKIN_M))
    blocked = np.isfinite(entered_m(hull, at, beams)) & (not is_within) if len(beams) else np.zeros(0)
    axis = beams.mean(axis=0) if is_dvl else None
    x, y, z = (float(along) for along in at)
    return Mount(
        key=key,
        name=name,
        position_m=(x, y, z),
        away_m=float(np.linalg.norm(outside)),
        off_down_deg=None if axis is None else _degrees_between(axis, DOWN),
        beams_in_hull=float(np.mean(blocked)) if len(blocked) else 0.0,
    )


def _mounted(model: VehicleModel) -> Iterator[tuple[str, str, ArrayLike, Floats, bool]]:
    """Yield each part's key, name, position, beam directions (n, 3) in the body frame, and whether it is a DVL."""
    blind = np.zeros((0, 3))
    for name, sensor in model.sensors.items():
        yield "sensors", name, sensor.position_m, beams_of(sensor), sensor.kind == "dvl"
    for name, camera in model.cameras.items():
        if camera.follows == "body":
            yield "cameras", name, camera.position_m, _turned(camera.yaw_pitch_roll_deg, AHEAD), False
    for name, sonar in model.imaging_sonars.items():
        looks = core_kind(imaging_kind(sonar.kind).model) != "side_scan"  # a side-scan has a transducer on each side
        ahead = _turned(sonar.yaw_pitch_roll_deg, AHEAD)
        yield "imaging_sonars", name, sonar.position_m, ahead if looks else blind, False
    if model.sonar is not None:
        yield "sonar", "", model.sonar.position_m, _turned((0.0, 0.0, 0.0), AHEAD), False
    for name, lamps in model.lamps.items():
        for spot in lamps.spots:
            yield "lamps", name, spot.position_m, _turned(spot.yaw_pitch_roll_deg, AHEAD), False
    for name, thruster in model.thrusters.items():
        yield "thrusters", name, thruster.position_m, blind, False
    for name, fin in model.fins.items():
        yield "fins", name, fin.position_m, blind, False
    if model.ballast_kg > 0.0:
        yield "ballast_position_m", "", model.ballast_position_m, blind, False


def beams_of(sensor: SensorMount) -> Floats:
    """Return the directions (n, 3) of a sensor's beams in the body frame; see cpp/uwsim/sensors/."""
    if sensor.kind == "dvl":
        slant, first = (_angle_rad(sensor, key) for key in ("beam_slant_deg", "beam_azimuth_deg"))
        azimuths = first + np.radians(90.0) * np.arange(DVL_BEAMS)
        down = np.column_stack(
            [
                np.sin(slant) * np.cos(azimuths),
                np.sin(slant) * np.sin(azimuths),
                np.full(DVL_BEAMS, -np.cos(slant)),
            ]
        )
        return turned(of_yaw_pitch_roll_deg(sensor.yaw_pitch_roll_deg), down)
    if sensor.kind == "altitude":  # stabilised: vertical regardless of its mounting
        return np.array([DOWN])
    if sensor.kind == "proximity":
        return _turned(sensor.yaw_pitch_roll_deg, AHEAD)
    return np.zeros((0, 3))


def _angle_rad(sensor: SensorMount, key: str) -> float:
    default = _core.sensor_kind(sensor.kind).parameters[key].by_default
    return float(np.radians(sensor.parameters.get(key, (default,))[0]))


def _turned(yaw_pitch_roll_deg: tuple[float, float, float], direction: tuple[float, float, float]) -> Floats:
    return turned(of_yaw_pitch_roll_deg(yaw_pitch_roll_deg), np.array([direction]))


def _degrees_between(one: ArrayLike, other: ArrayLike) -> float:
    a, b = np.asarray(one, np.float64), np.asarray(other, np.float64)
    cosine = float(a @ b) / float(np.linalg.norm(a) * np.linalg.norm(b))
    return float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))


def entered_m(hull: _core.RayScene, origin_m: Floats, directions: Floats) -> Floats:
    """Return the distances (n,) at which rays along unit vectors (n, 3) enter the hull from outside.

    inf for rays that miss it, and for rays from inside, which first meet a back face.
    """
    hits = hull.cast(origin_m + SKIN_M * directions, directions, FAR_M)
    enters = np.einsum("ij,ij->i", hits.normals_world, directions) < 0.0
    return np.where(enters, hits.ranges_m + SKIN_M, np.inf)
