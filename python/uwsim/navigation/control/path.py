"""Path following along straight segments with line-of-sight guidance."""

from __future__ import annotations

import math
from collections.abc import Sequence

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.sealed import Sealed
from uwsim.navigation.control.controller import Controller


class PathFollower(Sealed):
    """Guides a controller along a path; call `steer` once per control period.

    The vehicle faces along the path, or along its course if it cannot sway. points_m: waypoints (n, 3). lookahead_m:
    the distance ahead on the path to the point at which the vehicle aims. Near the path, the cross-track error decays
    at the rate speed / lookahead. integral_m_s: gain of the cross-track integral, for a vehicle that drifts in a
    current because it does not control its velocity over ground (cpp/uwsim/control/path_follower.h). If the thrust is
    insufficient for both speed and path, the vehicle stays on the path and slows down.
    """

    controller: Controller
    speed_m_s: float
    lookahead_m: float
    _fixed_when = "the path follower is made"

    def __init__(
        self,
        controller: Controller,
        points_m: Sequence[Sequence[float]] | Floats,
        speed_m_s: float,
        *,
        lookahead_m: float = 3.0,
        integral_m_s: float = 0.0,
    ) -> None:
        if not (math.isfinite(speed_m_s) and speed_m_s > 0.0):
            raise ValueError(f"speed_m_s = {speed_m_s} m/s: must be positive")
        self.controller = controller
        self.speed_m_s = speed_m_s
        self.lookahead_m = lookahead_m
        self._core = _core.PathFollower(points_m, lookahead_m, integral_m_s, controller.period_s)

    def __repr__(self) -> str:
        return f"<PathFollower at {self.speed_m_s:g} m/s, {self.lookahead_m:g} m ahead, by {self.controller!r}>"

    def steer(self) -> _core.Guidance:
        """Set the efforts for one control period. Return the guidance, which shows whether the end has been passed."""
        guidance = self._core.guide(self.controller.estimate.pose.position_world_m)
        velocity = self._core.pace(guidance.course_rad, self.speed_m_s, self.controller.force_share)
        heading = guidance.path_rad if self.controller.drives_sway else guidance.course_rad
        self.controller.steer(heading, velocity, guidance.z_world_m, across_first=True)
        return guidance
