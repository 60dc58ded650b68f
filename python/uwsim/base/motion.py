"""A vehicle's pose and velocity, true or estimated."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import cached_property

from uwsim.base.arrays import Floats
from uwsim.base.short_repr import ShortRepr


@dataclass(frozen=True, eq=False, repr=False, init=False)  # made every step; a frozen class's __init__ is slow
class Pose:
    """A vehicle's pose: position_world_m (3,), orientation_xyzw (4,), world_from_body (4, 4); ENU, REP 103."""

    position_world_m: Floats
    orientation_xyzw: Floats
    world_from_body: Floats

    def __init__(self, position_world_m: Floats, orientation_xyzw: Floats, world_from_body: Floats) -> None:
        own = self.__dict__
        own["position_world_m"], own["orientation_xyzw"] = position_world_m, orientation_xyzw
        own["world_from_body"] = world_from_body

    @cached_property
    def yaw_rad(self) -> float:
        """Heading of the body's x axis from east, counter-clockwise, in (-pi, pi]."""
        return math.atan2(self.world_from_body[1, 0], self.world_from_body[0, 0])

    def to_dict(self) -> dict[str, Floats]:
        """Return the arrays by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def __repr__(self) -> str:
        east, north, up = self.position_world_m.tolist()
        turn = ", ".join(f"{part:.4f}" for part in self.orientation_xyzw.tolist())
        yaw_deg = math.degrees(self.yaw_rad)
        return f"Pose(({east:.3f}, {north:.3f}, {up:.3f}) m, yaw {yaw_deg:.1f} deg, orientation x y z w ({turn}))"


@dataclass(frozen=True, eq=False, init=False, repr=False)  # as for Pose
class Velocity(ShortRepr):
    """A vehicle's velocity over ground, in body axes: linear_body_m_s (3,), angular_body_rad_s (3,)."""

    linear_body_m_s: Floats
    angular_body_rad_s: Floats

    def __init__(self, linear_body_m_s: Floats, angular_body_rad_s: Floats) -> None:
        own = self.__dict__
        own["linear_body_m_s"], own["angular_body_rad_s"] = linear_body_m_s, angular_body_rad_s

    def to_dict(self) -> dict[str, Floats]:
        """Return the arrays by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}
