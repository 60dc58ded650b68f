"""Pose and velocity of a vehicle, true or estimated."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Pose:
    """A vehicle's pose: position_world_m (3,), orientation_xyzw (4,), world_from_body (4, 4); ENU, REP 103."""

    position_world_m: Vector
    orientation_xyzw: Vector
    world_from_body: Vector

    @cached_property
    def yaw_rad(self) -> float:
        """Heading of the body's x axis from east, counter-clockwise, in (-pi, pi]."""
        return math.atan2(self.world_from_body[1, 0], self.world_from_body[0, 0])


@dataclass(frozen=True, eq=False)
class Velocity:
    """A vehicle's velocity over ground, in body axes: linear_body_m_s (3,), angular_body_rad_s (3,)."""

    linear_body_m_s: Vector
    angular_body_rad_s: Vector
