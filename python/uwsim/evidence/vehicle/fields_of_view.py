"""The fields of view of a vehicle's instruments, and the share of each that its own hull blocks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwsim.base.quaternions import of_yaw_pitch_roll_deg, turned
from uwsim.evidence.vehicle.mounts import beams_of, entered_m
from uwsim.instruments.sonars.imaging import Acoustics, ForwardLooking, SideScan
from uwsim.scenario.build.hull import hull_scene, vehicle_hull
from uwsim.simulator.simulator import Simulator

Floats = NDArray[np.float64]
ACROSS, UP = 64, 24


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


def fields_of_view(sim: Simulator) -> tuple[FieldOfView, ...]:
    """Return the fields of view of the first vehicle's cameras, sonars, lamps and sensors with beams."""
    model = sim.scenario.vehicles[0].model
    scene = hull_scene(*vehicle_hull(model))
    found = []
    for label, position_m, rays in _fields(sim):
        at, unit = np.asarray(position_m, np.float64), rays / np.linalg.norm(rays, axis=1)[:, None]
        reached_m = entered_m(scene, at, unit)
        on_hull = np.isfinite(reached_m)
        found.append(FieldOfView(label, at, unit, on_hull, float(reached_m.min(initial=np.inf))))
    return tuple(found)


def _fields(sim: Simulator) -> Iterator[tuple[str, tuple[float, ...], Floats]]:
    """Yield label, position (3,) and rays (n, 3) of each instrument that has a field of view, body frame."""
    model, vehicle = sim.scenario.vehicles[0].model, sim.rov
    for name, sensor in model.sensors.items():
        if len(beams := beams_of(sensor)):
            yield f"sensors.{name}", sensor.position_m, beams
    for name, camera in model.cameras.items():
        if camera.follows == "body":
            table = (
                vehicle.cameras[name].resized(ACROSS).ray_table().reshape(-1, 2).astype(np.float64)
            )  # X/Z and Y/Z, right and down
            yield (
                f"cameras.{name}",
                camera.position_m,
                _turned(camera.yaw_pitch_roll_deg, _ahead(-table[:, 0], -table[:, 1])),
            )
    if model.sonar is not None:
        ping = vehicle.sonar.ping()
        body_from_sonar = np.linalg.inv(vehicle.pose.world_from_body) @ ping.world_from_sonar
        fan = np.column_stack([np.cos(ping.angles_rad), np.sin(ping.angles_rad), np.zeros(len(ping.angles_rad))])
        yield "sonar", tuple(body_from_sonar[:3, 3]), fan @ body_from_sonar[:3, :3].T
    for name, sonar in model.imaging_sonars.items():
        yield (
            f"imaging_sonars.{name}",
            sonar.position_m,
            _turned(sonar.yaw_pitch_roll_deg, _pattern(vehicle.imaging_sonars[name].model)),
        )
    for name, lamps in model.lamps.items():
        for spot in lamps.spots:
            yield (
                f"lamps.{name}",
                spot.position_m,
                _turned(spot.yaw_pitch_roll_deg, _cone(np.radians(lamps.half_angle_deg))),
            )


def _pattern(sonar: Acoustics) -> Floats:
    """Return rays (n, 3) over the field of an imaging sonar, within its half-power widths, in its own frame."""
    if isinstance(sonar, ForwardLooking):
        return _fan(sonar.field_of_view_rad, sonar.vertical_width_rad)
    if isinstance(sonar, SideScan):
        up = np.linspace(-0.5, 0.5, ACROSS) * sonar.vertical_width_rad - sonar.depression_rad
        sides = [np.column_stack([np.zeros(ACROSS), side * np.cos(up), np.sin(up)]) for side in (1.0, -1.0)]
        return np.concatenate(sides)
    turns = np.linspace(-np.pi, np.pi, ACROSS, endpoint=False)  # a single beam, which is steered all around
    return np.column_stack([np.cos(turns), np.sin(turns), np.zeros(ACROSS)])


def _fan(across_rad: float, up_rad: float) -> Floats:
    bearing, rise = np.meshgrid(np.linspace(-0.5, 0.5, ACROSS) * across_rad, np.linspace(-0.5, 0.5, UP) * up_rad)
    rays = np.stack([np.cos(rise) * np.cos(bearing), np.cos(rise) * np.sin(bearing), np.sin(rise)], axis=-1)
    return np.asarray(rays.reshape(-1, 3))


def _cone(half_rad: float) -> Floats:
    """Return rays (n, 3) of equal solid angle about x."""
    count = ACROSS * UP
    cosines = 1.0 - (np.arange(count) + 0.5) / count * (1.0 - np.cos(half_rad))
    turns = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(count)
    sines = np.sqrt(1.0 - cosines**2)
    return np.column_stack([cosines, sines * np.cos(turns), sines * np.sin(turns)])


def _ahead(left: Floats, up: Floats) -> Floats:
    return np.column_stack([np.ones(len(left)), left, up])


def _turned(yaw_pitch_roll_deg: Sequence[float], rays: Floats) -> Floats:
    return turned(of_yaw_pitch_roll_deg(yaw_pitch_roll_deg), rays)
