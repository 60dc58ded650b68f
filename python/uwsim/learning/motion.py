"""The motion of batch members, with conversions to the axes that tasks need."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arrays import Floats
from uwsim.base.short_repr import ShortRepr
from uwsim.batch import BatchMotion
from uwsim.navigation.control import EstimateLike


@dataclass(frozen=True, eq=False, repr=False)
class Motion(ShortRepr):
    """The true motion of a vehicle in each member of a batch.

    position_world_m: (n, 3). world_from_body: (n, 3, 3). velocity_body: (n, 6), linear and angular [m/s, rad/s].
    time_s: (n,), time since each member's start. collisions: (n,), number of contacts begun.
    """

    position_world_m: Floats
    world_from_body: Floats
    velocity_body: Floats
    time_s: Floats
    collisions: NDArray[np.uint64]

    @staticmethod
    def of(batch: BatchMotion) -> Motion:
        """Return a copy of the motion in a batch."""
        return Motion(
            batch.position_world_m.copy(),
            rotations(batch.orientation_xyzw),
            batch.velocity_body.copy(),
            np.asarray(1e-9 * batch.time_ns, np.float64),
            batch.collisions.copy(),
        )

    @staticmethod
    def of_one(vehicle: EstimateLike) -> Motion:
        """Return a single vehicle's own estimate, at time 0 and without collisions, for flying a policy."""
        pose, velocity = vehicle.pose, vehicle.velocity
        return Motion(
            np.asarray(pose.position_world_m, np.float64)[None],
            np.asarray(pose.world_from_body, np.float64)[None, :3, :3],
            np.concatenate([velocity.linear_body_m_s, velocity.angular_body_rad_s])[None],
            np.zeros(1),
            np.zeros(1, np.uint64),
        )

    @property
    def up_body(self) -> Floats:
        """The world's z axis in body axes, (n, 3)."""
        return self.world_from_body[:, 2, :]

    @property
    def heading(self) -> Floats:
        """The horizontal part of the body's x axis in the world, (n, 2)."""
        return self.world_from_body[:, :2, 0]

    def in_body(self, vectors_world: Floats) -> Floats:
        """Return world vectors, (n, 3) or (3,), in the body axes of each member."""
        vectors = np.broadcast_to(vectors_world, self.position_world_m.shape)
        return np.asarray(np.einsum("nij,ni->nj", self.world_from_body, vectors))

    def towards(self, place_world_m: Floats) -> Floats:
        """Return the vector to a position, (n, 3) or (3,), in the body axes of each member."""
        return self.in_body(place_world_m - self.position_world_m)


def rotations(orientation_xyzw: Floats) -> Floats:
    """Return the matrices (n, 3, 3) of unit quaternions (n, 4)."""
    x, y, z, w = orientation_xyzw.T
    return np.stack([
        1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),
        2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
        2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y),
    ], axis=-1).reshape(-1, 3, 3)  # fmt: skip


def yaw_xyzw(yaw_rad: Floats) -> Floats:
    """Return rotations (m, 4) about z by angles (m,)."""
    zero = np.zeros_like(yaw_rad)
    return np.stack([zero, zero, np.sin(0.5 * yaw_rad), np.cos(0.5 * yaw_rad)], axis=-1)
