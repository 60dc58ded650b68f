"""The station's dock: its docked pose, its exit pose, and the conditions for docking and undocking."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.quaternions import about_z

CAPTURE_M, CAPTURE_M_S, CAPTURE_DEG = 1.5, 0.5, 30.0
"""The largest distance, speed and heading error at which a vehicle can dock."""
CLEARANCE_M = 0.1
"""Clearance that an undocked vehicle's hull needs on all sides."""


class DockedWarning(UserWarning):
    """Issued when a docked vehicle is commanded: the command has no effect because the thrusters are off."""


@dataclass(frozen=True, eq=False)
class Dock:
    """The dock of a simulator's station.

    docked_m (3,): origin of a docked vehicle. exit_m (3,): its origin just after undocking. heading_rad: the vehicle's
    heading at both. All are in the world frame, or in that of the vehicle with the index `carrier`. hull_radii_m:
    hull radius of each vehicle about its origin.
    """

    simulation: _core.Simulation
    scene: _core.RayScene
    docked_m: Floats
    exit_m: Floats
    heading_rad: float
    carrier: int | None = None
    hull_radii_m: list[float] = field(default_factory=list)

    @property
    def position_world_m(self) -> Floats:
        """Return the origin (3,) of a docked vehicle now."""
        return self._in_world(self.docked_m)

    @property
    def exit_world_m(self) -> Floats:
        """Return the origin (3,) of a vehicle that undocks now."""
        return self._in_world(self.exit_m)

    @property
    def yaw_rad(self) -> float:
        """Return a docked vehicle's heading now."""
        if self.carrier is None:
            return self.heading_rad
        ahead = self.simulation.state(self.carrier).world_from_body[:3, 0]
        return math.atan2(ahead[1], ahead[0]) + self.heading_rad

    def _in_world(self, point_m: Floats) -> Floats:
        if self.carrier is None:
            return point_m
        world_from_body = self.simulation.state(self.carrier).world_from_body
        return np.asarray(world_from_body[:3, :3] @ point_m + world_from_body[:3, 3])

    def _approach_m_s(self, state: _core.BodyState) -> float:
        """Return a vehicle's speed relative to the dock."""
        if self.carrier is None:
            return float(np.linalg.norm(state.velocity_body[:3]))
        boat = self.simulation.state(self.carrier)
        own, of_boat = (one.world_from_body[:3, :3] @ one.velocity_body[:3] for one in (state, boat))
        return float(np.linalg.norm(own - of_boat))

    @property
    def orientation_xyzw(self) -> Floats:
        """Return the orientation (4,) of a vehicle in the dock and at the exit."""
        return about_z(self.yaw_rad)

    def require_exit(self, vehicle: int) -> None:
        """Raise ValueError unless the exit has room for the vehicle's hull, clear of obstacles and other vehicles."""
        needed_m = self.hull_radii_m[vehicle] + CLEARANCE_M
        free_m = float(self.scene.distance_m(self.exit_world_m[None])[0])
        if free_m < needed_m:
            raise ValueError(f"{self._exit_text}: a surface is {free_m:.2f} m away, must be at least {needed_m:.2f} m")
        for other, radius_m in enumerate(self.hull_radii_m):
            apart_m = math.dist(self.simulation.state(other).position_world_m, self.exit_world_m)
            if other != vehicle and apart_m < needed_m + radius_m:
                raise ValueError(f"{self._exit_text}: another vehicle is {apart_m:.2f} m away")

    def require_entry(self, vehicle: int) -> None:
        """Raise ValueError unless the dock is empty, and the vehicle is close to it, slow and aligned with it.

        A dock above the water can be lowered to the vehicle's height, but not below the surface: the distance is
        measured from there.
        """
        for other in range(len(self.hull_radii_m)):
            if other != vehicle and not self.simulation.released(other):
                raise ValueError("dock: occupied by another vehicle")
        state = self.simulation.state(vehicle)
        east_m, north_m, dock_m = self.position_world_m
        reached_m = min(max(float(state.position_world_m[2]), 0.0), dock_m) if dock_m > 0.0 else dock_m
        away_m = (east_m, north_m, reached_m) - state.position_world_m
        distance_m = float(np.linalg.norm(away_m))
        if distance_m > CAPTURE_M:
            east, north, up = away_m
            raise ValueError(
                f"dock: it is {distance_m:.1f} m away ({east:.1f} m east, {north:.1f} m north, {up:.1f} m up), "
                f"must be within {CAPTURE_M} m"
            )
        speed_m_s = self._approach_m_s(state)
        if speed_m_s > CAPTURE_M_S:
            raise ValueError(f"dock: speed = {speed_m_s:.2f} m/s: must be at most {CAPTURE_M_S} m/s")
        ahead = state.world_from_body[:3, 0] @ (math.cos(self.yaw_rad), math.sin(self.yaw_rad), 0.0)
        off_deg = math.degrees(math.acos(min(max(float(ahead), -1.0), 1.0)))
        if off_deg > CAPTURE_DEG:
            raise ValueError(
                f"dock: it points {off_deg:.0f} degrees away from the dock's heading, "
                f"{math.degrees(self.yaw_rad):.0f} degrees from east: must be within {CAPTURE_DEG:g}"
            )

    @property
    def _exit_text(self) -> str:
        x, y, z = self.exit_world_m
        return f"station.exit_m: ({x:.1f}, {y:.1f}, {z:.1f}) m in the world is not free"
