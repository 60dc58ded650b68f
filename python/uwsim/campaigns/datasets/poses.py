"""Random poses for pictures: in open water, with a target in view."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from uwsim.base.arrays import Floats
from uwsim.campaigns.datasets.targets import Targets
from uwsim.simulator.simulator import Simulator

BATCH, MAX_BATCHES = 64, 200
"""The number of poses drawn at once, and the number of batches tried before the limits are considered too narrow."""
MARGIN = 0.1
"""The fraction of the picture at each border in which the target point must not lie."""
SEEN_M = 0.05
"""A target point counts as visible if the line of sight ends at most this far in front of it."""


@dataclass(frozen=True, eq=False)
class Viewpoint:
    """A pose of the vehicle (orientation as x, y, z, w) and the name of the camera's target (None on a track)."""

    position_m: Floats
    orientation_xyzw: Floats
    target: str | None = None
    distance_m: float | None = None


@dataclass(frozen=True, eq=False)
class Eye:
    """A camera on its vehicle: position_m (3,), and rotation (3, 3) from its frame (x ahead, y left) to the body frame.

    rays: (H, W, 2), X/Z and Y/Z of each pixel in the optical frame. hull_radius_m: radius of a sphere about the
    vehicle's origin that contains the hull.
    """

    position_m: Floats
    rotation: Floats
    rays: NDArray[np.float32]
    hull_radius_m: float


@dataclass(frozen=True)
class Limits:
    """The limits on viewpoints; see DatasetSpec."""

    distance_m: tuple[float, float]
    clearance_m: float
    pitch_max_rad: float
    roll_max_rad: float


class FreeWater:
    """Checks which positions of a vehicle and its camera are under water and clear of all obstacles."""

    def __init__(self, sim: Simulator, carrier: str, eye: Eye, clearance_m: float) -> None:
        self._world, self._scene = sim.world, sim.around(carrier).scene
        self._hull_m, self._eye_m = eye.hull_radius_m + clearance_m, clearance_m

    def under_water(self, bodies_m: Floats, eyes_m: Floats) -> NDArray[np.bool_]:
        """Return a mask (n,) from quick checks that positions are above the ground and below the surface."""
        free = np.ones(len(bodies_m), bool)
        for points, clear_m in ((bodies_m, self._hull_m), (eyes_m, self._eye_m)):
            ground = self._world.height_at(points[:, :2])
            has_ground = self._world.highest_m > -np.inf
            above = points[:, 2] - clear_m > ground if has_ground else True  # False outside the terrain (NaN)
            free &= (points[:, 2] + clear_m < 0.0) & above
        return free

    def clear(self, body_m: Floats, eye_m: Floats) -> bool:
        """Return whether the hull and the camera keep their clearance from everything."""
        points = np.array([body_m, eye_m])
        if not (self._scene.distance_m(points) >= (self._hull_m, self._eye_m)).all():
            return False
        return all(self._world.solid_around(point) is None for point in points)

    def sees(self, eye_m: Floats, point_m: Floats) -> bool:
        """Return whether the line of sight from the eye to a point is clear."""
        return bool(self._scene.visible(eye_m, point_m[None], SEEN_M)[0])


def draw_viewpoint(
    targets: Targets, water: FreeWater, eye: Eye, limits: Limits, random: np.random.Generator
) -> Viewpoint:
    """Return a pose from which a target point is visible at a random pixel. Raises ValueError if none is found.

    The vehicle's heading, pitch and roll, the pixel and the distance are drawn uniformly within their limits; together
    they determine the camera's position.
    """
    under_water = clear = 0
    for _ in range(MAX_BATCHES):
        which, points = targets.draw(BATCH, random)
        turns = Rotation.from_euler("ZYX", _angles_rad(limits, random))
        distances = random.uniform(*limits.distance_m, BATCH)
        body_from_ray = _rays(eye, random) @ eye.rotation.T
        eyes = points - distances[:, None] * turns.apply(body_from_ray)
        bodies = eyes - turns.apply(eye.position_m)
        for k in np.flatnonzero(water.under_water(bodies, eyes) & (points[:, 2] < 0.0)):
            under_water += 1
            if water.clear(bodies[k], eyes[k]):
                clear += 1
                if water.sees(eyes[k], points[k]):
                    orientation = np.asarray(turns[int(k)].as_quat(), np.float64)
                    return Viewpoint(bodies[k], orientation, targets.names[which[k]], float(distances[k]))
    low, high = limits.distance_m
    raise ValueError(
        f"no pose was found among {BATCH * MAX_BATCHES:,} that looks at {', '.join(targets.names)} from {low:.3g} to "
        f"{high:.3g} m: {under_water:,} were in the water, {clear:,} of these clear of everything, and none saw its "
        "point; change look_at, distance_m, clearance_m or pitch_max_deg"
    )


def _angles_rad(limits: Limits, random: np.random.Generator) -> Floats:
    """Return random yaw, pitch and roll, (BATCH, 3)."""
    bounds = np.array([np.pi, limits.pitch_max_rad, limits.roll_max_rad])
    return random.uniform(-bounds, bounds, (BATCH, 3))


def _rays(eye: Eye, random: np.random.Generator) -> Floats:
    """Return unit vectors towards random pixels in the camera frame, (BATCH, 3): x ahead, y left, z up."""
    height, width = eye.rays.shape[:2]
    share = random.uniform(MARGIN, 1 - MARGIN, (BATCH, 2))
    rows, columns = (share[:, 0] * height).astype(int), (share[:, 1] * width).astype(int)
    xy = eye.rays[rows, columns].astype(np.float64)
    rays = np.column_stack([np.ones(BATCH), -xy])
    return np.asarray(rays / np.linalg.norm(rays, axis=1, keepdims=True))
