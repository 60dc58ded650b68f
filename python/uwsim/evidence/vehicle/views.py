"""A vehicle's parts: how far each is from the hull, where it looks, and how much of that the hull blocks."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import ConvexHull

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.quaternions import of_yaw_pitch_roll_deg, turned
from uwsim.instruments.sonars.imaging import Acoustics, ForwardLooking, SideScan
from uwsim.scenario.build.hull import hull_scene, vehicle_hull
from uwsim.scenario.spec.imaging_sonar import core_kind, imaging_kind
from uwsim.scenario.spec.sensor import SensorMount
from uwsim.scenario.spec.vehicle import VehicleModel
from uwsim.simulator.simulator import Simulator
from uwsim.simulator.vehicle import Vehicle

AHEAD, DOWN, BLIND = np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 0.0, -1.0]]), np.zeros((0, 3))
DVL_BEAMS = 4
ACROSS, UP = 64, 24
"""Rays of a field of view."""
SKIN_M, FAR_M = 1e-3, 1e3
"""Surfaces closer to an instrument than this belong to the skin in which the instrument is mounted."""
LEVEL_DEG = (0.0, 0.0, 0.0)


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
        return _label(self.key, self.name)


@dataclass(frozen=True, eq=False)
class FieldOfView:
    """The field of view of one instrument, body frame.

    label: its key in the vehicle's file, such as `cameras.front`. position_m (3,). rays: (n, 3) unit vectors, spread
    over its field. on_hull: (n,) whether a ray meets the hull from outside; instruments inside the hull look out
    through it.
    nearest_m: distance to the hull along those rays; inf if none meets it.
    """

    label: str
    position_m: Floats
    rays: Floats
    on_hull: NDArray[np.bool_]
    nearest_m: float

    @property
    def share(self) -> float:
        """The share of the rays that meet the hull."""
        return float(self.on_hull.mean())


class _Part(NamedTuple):
    """A part of the file. lines: its beams or line of sight (n, 3), body frame. field: its whole field, own frame."""

    key: str
    name: str
    position_m: ArrayLike
    lines: Floats = BLIND
    turn_deg: tuple[float, float, float] = LEVEL_DEG
    field: Callable[[Vehicle], Floats] | None = None


def _parts(model: VehicleModel) -> Iterator[_Part]:
    for name, sensor in model.sensors.items():
        yield _Part("sensors", name, sensor.position_m, beams_of(sensor))
    for name, camera in model.cameras.items():
        if camera.follows == "body":
            yield _looking("cameras", name, camera, lambda rov, name=name: _picture(rov, name))
    if model.sonar is not None:
        yield _Part("sonar", "", model.sonar.position_m, AHEAD)
    for name, sonar in model.imaging_sonars.items():
        part = _looking("imaging_sonars", name, sonar, lambda rov, name=name: _pattern(rov.imaging_sonars[name].model))
        is_sideways = core_kind(imaging_kind(sonar.kind).model) == "side_scan"  # with a transducer on each side
        yield part._replace(lines=BLIND) if is_sideways else part
    for name, lamps in model.lamps.items():
        for spot in lamps.spots:
            yield _looking("lamps", name, spot, lambda _, half=lamps.half_angle_deg: _cone(np.radians(half)))
    for key in ("thrusters", "fins"):
        yield from (_Part(key, name, part.position_m) for name, part in getattr(model, key).items())
    if model.ballast_kg > 0.0:
        yield _Part("ballast_position_m", "", model.ballast_position_m)


def _looking(key: str, name: str, mount: Any, field: Callable[..., Floats]) -> _Part:
    turn_deg = mount.yaw_pitch_roll_deg
    return _Part(key, name, mount.position_m, _turned(turn_deg, AHEAD), turn_deg, field)


def mounts(model: VehicleModel) -> tuple[Mount, ...]:
    """Return all mounts of a model. Raises ScenarioError if its mesh is not a valid hull."""
    vertices, triangles = vehicle_hull(model)
    hull, sides = hull_scene(vertices, triangles), ConvexHull(vertices).equations
    low_m, high_m = vertices.min(axis=0), vertices.max(axis=0)

    def mount(part: _Part) -> Mount:
        at, axis = np.asarray(part.position_m, np.float64), None
        outside = np.maximum(0.0, np.maximum(low_m - at, at - high_m))
        is_within = bool(np.all(sides[:, :3] @ at + sides[:, 3] <= SKIN_M))
        blocked = 0.0
        if len(part.lines) and not is_within:
            blocked = float(np.mean(np.isfinite(entered_m(hull, at, part.lines))))
        if part.key == "sensors" and model.sensors[part.name].kind == "dvl":
            axis = part.lines.mean(axis=0)
        x, y, z = at.tolist()
        off_deg = None if axis is None else _degrees_between(axis, DOWN[0])
        return Mount(part.key, part.name, (x, y, z), float(np.linalg.norm(outside)), off_deg, blocked)

    return tuple(mount(part) for part in _parts(model))


def fields_of_view(sim: Simulator) -> tuple[FieldOfView, ...]:
    """Return the fields of view of the first vehicle's cameras, sonars, lamps and sensors with beams."""
    model, rov = sim.scenario.vehicles[0].model, sim.rov
    scene, found = hull_scene(*vehicle_hull(model)), []
    for part in _parts(model):
        at, rays = np.asarray(part.position_m, np.float64), part.lines
        if part.key == "sonar":
            at, rays = _fan_of_ping(rov)
        elif part.field is not None:
            rays = _turned(part.turn_deg, part.field(rov))
        if len(rays):
            unit = rays / np.linalg.norm(rays, axis=1)[:, None]
            reached_m = entered_m(scene, at, unit)
            nearest_m = float(reached_m.min(initial=np.inf))
            found.append(FieldOfView(_label(part.key, part.name), at, unit, np.isfinite(reached_m), nearest_m))
    return tuple(found)


def _label(key: str, name: str) -> str:
    return f"{key}.{name}" if name else key


def beams_of(sensor: SensorMount) -> Floats:
    """Return the directions (n, 3) of a sensor's beams in the body frame; see cpp/uwsim/sensors/."""
    if sensor.kind == "dvl":
        slant, first = (_angle_rad(sensor, key) for key in ("beam_slant_deg", "beam_azimuth_deg"))
        azimuths = first + np.radians(90.0) * np.arange(DVL_BEAMS)
        across = np.sin(slant) * np.array([np.cos(azimuths), np.sin(azimuths)])
        return _turned(sensor.yaw_pitch_roll_deg, np.column_stack([*across, np.full(DVL_BEAMS, -np.cos(slant))]))
    if sensor.kind == "altitude":  # stabilised: vertical regardless of its mounting
        return DOWN
    return _turned(sensor.yaw_pitch_roll_deg, AHEAD) if sensor.kind == "proximity" else BLIND


def _angle_rad(sensor: SensorMount, key: str) -> float:
    default = _core.sensor_kind(sensor.kind).parameters[key].by_default
    return float(np.radians(sensor.parameters.get(key, (default,))[0]))


def _picture(rov: Vehicle, camera: str) -> Floats:
    """Return rays (n, 3) through the pixels of a small picture, x ahead."""
    table = rov.cameras[camera].resized(ACROSS).ray_table().reshape(-1, 2).astype(np.float64)
    return np.column_stack([np.ones(len(table)), -table])  # X/Z and Y/Z, right and down


def _fan_of_ping(rov: Vehicle) -> tuple[Floats, Floats]:
    """Return the sonar's position (3,) and the directions (n, 3) of its beams as it is aimed, body frame."""
    ping = rov.sonar.ping()
    body_from_sonar = np.linalg.inv(rov.pose.world_from_body) @ ping.world_from_sonar
    fan = np.column_stack([np.cos(ping.angles_rad), np.sin(ping.angles_rad), np.zeros(len(ping.angles_rad))])
    return body_from_sonar[:3, 3], fan @ body_from_sonar[:3, :3].T


def _pattern(sonar: Acoustics) -> Floats:
    """Return rays (n, 3) over the field of an imaging sonar, within its half-power widths, in its own frame."""
    if isinstance(sonar, ForwardLooking):
        across_rad, up_rad = sonar.field_of_view_rad, sonar.vertical_width_rad
        bearing, rise = np.meshgrid(np.linspace(-0.5, 0.5, ACROSS) * across_rad, np.linspace(-0.5, 0.5, UP) * up_rad)
        rays = np.stack([np.cos(rise) * np.cos(bearing), np.cos(rise) * np.sin(bearing), np.sin(rise)], axis=-1)
        return np.asarray(rays.reshape(-1, 3))
    if isinstance(sonar, SideScan):
        up = np.linspace(-0.5, 0.5, ACROSS) * sonar.vertical_width_rad - sonar.depression_rad
        sides = [np.column_stack([np.zeros(ACROSS), side * np.cos(up), np.sin(up)]) for side in (1.0, -1.0)]
        return np.concatenate(sides)
    turns = np.linspace(-np.pi, np.pi, ACROSS, endpoint=False)  # a single beam, which is steered all around
    return np.column_stack([np.cos(turns), np.sin(turns), np.zeros(ACROSS)])


def _cone(half_rad: float) -> Floats:
    """Return rays (n, 3) of equal solid angle about x."""
    count = ACROSS * UP
    cosines = 1.0 - (np.arange(count) + 0.5) / count * (1.0 - np.cos(half_rad))
    turns = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(count)
    sines = np.sqrt(1.0 - cosines**2)
    return np.column_stack([cosines, sines * np.cos(turns), sines * np.sin(turns)])


def _turned(yaw_pitch_roll_deg: tuple[float, float, float], rays: Floats) -> Floats:
    return turned(of_yaw_pitch_roll_deg(yaw_pitch_roll_deg), rays)


def _degrees_between(one: Floats, other: Floats) -> float:
    cosine = float(one @ other) / float(np.linalg.norm(one) * np.linalg.norm(other))
    return float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))


def entered_m(hull: _core.RayScene, origin_m: Floats, directions: Floats) -> Floats:
    """Return the distances (n,) at which rays along unit vectors (n, 3) enter the hull from outside.

    inf for rays that miss it, and for rays from inside, which first meet a back face.
    """
    hits = hull.cast(origin_m + SKIN_M * directions, directions, FAR_M)
    enters = np.einsum("ij,ij->i", hits.normals_world, directions) < 0.0
    return np.where(enters, hits.ranges_m + SKIN_M, np.inf)
