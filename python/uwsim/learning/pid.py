"""The PID controller from the vehicle file as a policy, for comparison with learned policies."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.axes import AXES
from uwsim.learning.episodes import Episodes
from uwsim.navigation.control import Controller
from uwsim.scenario import control_settings
from uwsim.scenario.build.water import surface_density_kg_m3

Floats = NDArray[np.float64]


@dataclass
class _Pose:
    world_from_body: Floats

    @property
    def position_world_m(self) -> Floats:
        return self.world_from_body[:3, 3]

    @property
    def yaw_rad(self) -> float:
        return float(np.arctan2(self.world_from_body[1, 0], self.world_from_body[0, 0]))


@dataclass
class _Velocity:
    linear_body_m_s: Floats
    angular_body_rad_s: Floats


@dataclass
class _Member:
    """A batch member in its true state, with the interface that a controller needs."""

    pose: _Pose = field(default_factory=lambda: _Pose(np.eye(4)))
    velocity: _Velocity = field(default_factory=lambda: _Velocity(np.zeros(3), np.zeros(3)))
    effort: tuple[float, ...] = (0.0,) * len(AXES)

    def set_effort(self, *efforts: float) -> None:
        self.effort = efforts


class Pid:
    """Holds a position (3,) and heading in all members with the control loops in the vehicle file; see `Controller`.

    Like a policy, it acts once per period. It receives the true motion, and takes one Python call per member and
    period.
    """

    def __init__(self, episodes: Episodes, place_world_m: Floats, heading_rad: float = 0.0) -> None:
        entry = episodes.batch.scenario.vehicles[0]
        settings = control_settings(entry.model, surface_density_kg_m3(episodes.batch.scenario.water))
        self._episodes = episodes
        self._place, self._heading = place_world_m, heading_rad
        self._members = [_Member() for _ in range(episodes.n)]
        self._controllers = [Controller(m, episodes.period_s, settings=settings) for m in self._members]

    def __call__(self, observation: Any) -> Floats:
        """Return the efforts of all members, (n, 6). observation: ignored."""
        motion = self._episodes.motion
        for k, (member, controller) in enumerate(zip(self._members, self._controllers, strict=True)):
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = motion.world_from_body[k], motion.position_world_m[k]
            member.pose = _Pose(pose)
            member.velocity = _Velocity(motion.velocity_body[k, :3], motion.velocity_body[k, 3:])
            controller.hold(self._place, self._heading)
        return np.array([member.effort for member in self._members])
