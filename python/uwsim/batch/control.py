"""Controllers of a batch: the control loops of one vehicle in every member, computed in one call."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwsim import _core
from uwsim.base.axes import AXES
from uwsim.base.sealed import Sealed
from uwsim.batch import arguments
from uwsim.batch.batch import Batch
from uwsim.batch.results import BatchEstimate, BatchGuidance, BatchMotion
from uwsim.navigation.control.autopilot import Gains, steady_gains

Floats = NDArray[np.float64]
LEVEL = (0.0, 0.0, 0.0)


class _Pilot(Sealed):
    """The common part of all controllers: the vehicle, and the motion that is used for control."""

    batch: Batch
    vehicle: str
    period_s: float
    uses_estimate: bool
    _fixed_when = "the controller is made"

    def __init__(self, batch: Batch, period_s: float, vehicle: str | None, *, uses_estimate: bool) -> None:
        names = [entry.name for entry in batch.scenario.vehicles]
        self.batch = batch
        self.vehicle = names[0] if vehicle is None else vehicle
        batch.observe(self.vehicle)  # raises if there is no such vehicle
        self.period_s = period_s
        self.uses_estimate = uses_estimate

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {self.vehicle} in {self.batch!r}, every {self.period_s:g} s>"

    @property
    def motion(self) -> BatchMotion | BatchEstimate:
        """The motion that is used for control: the estimate if `uses_estimate`, and otherwise the true motion."""
        return self.batch.estimate(self.vehicle) if self.uses_estimate else self.batch.observe(self.vehicle)

    def _estimates(self) -> tuple[Floats, Floats, Floats]:
        motion = self.motion
        return motion.position_world_m, motion.orientation_xyzw, motion.velocity_body

    def _each(self, value: ArrayLike, name: str) -> Floats:
        return arguments.each(value, name, self.batch.n)

    def _rows(self, value: ArrayLike, name: str, width: int) -> Floats:
        rows = arguments.rows(value, name, self.batch.n, width)
        arguments.require_finite(rows, name)
        return rows


class BatchController(_Pilot):
    """A Controller of one vehicle in each member. Call `hold`, `steer` or `velocity` once per control period.

    Member k gets the efforts that Controller(sim.rov, period_s) would set. uses_estimate: whether it acts on
    Batch.estimate. vehicle: by default the first. Arguments have one row per member, or a single row for all. Raises
    ValueError.
    """

    def __init__(
        self, batch: Batch, period_s: float = 0.05, *, vehicle: str | None = None, uses_estimate: bool = False
    ) -> None:
        super().__init__(batch, period_s, vehicle, uses_estimate=uses_estimate)
        settings = batch.control(self.vehicle)
        self._sway = settings.model.driven[1]
        self._core = _core.BatchMotionController(settings.model, settings.gains, period_s, batch.n, batch.threads)

    @property
    def drives_sway(self) -> bool:
        """True if the vehicle can move sideways."""
        return self._sway

    @property
    def force_share(self) -> Floats:
        """The fraction (n,) of the required force that the thrusters produced last period; below 1 at their limit."""
        return self._core.force_shares

    def hold(
        self,
        position_world_m: ArrayLike,
        heading_rad: ArrayLike,
        *,
        roll_rad: ArrayLike = 0.0,
        pitch_rad: ArrayLike = 0.0,
        velocity_world_m_s: ArrayLike = LEVEL,
    ) -> None:
        """Go to positions (n, 3) and attitudes (n,), and hold them; see Controller.hold."""
        efforts = self.hold_efforts(
            position_world_m, heading_rad, roll_rad=roll_rad, pitch_rad=pitch_rad, velocity_world_m_s=velocity_world_m_s
        )
        self.batch.set_effort(efforts, self.vehicle)

    def hold_efforts(
        self,
        position_world_m: ArrayLike,
        heading_rad: ArrayLike,
        *,
        roll_rad: ArrayLike = 0.0,
        pitch_rad: ArrayLike = 0.0,
        velocity_world_m_s: ArrayLike = LEVEL,
    ) -> Floats:
        """Return the efforts (n, 6) that `hold` would set."""
        positions = arguments.rows(position_world_m, "position_world_m", self.batch.n, 3)
        velocities = self._rows(velocity_world_m_s, "velocity_world_m_s", 3)
        return self._reached(positions, velocities, heading_rad, roll_rad, pitch_rad)

    def steer(
        self,
        heading_rad: ArrayLike,
        velocity_world_m_s: ArrayLike,
        z_world_m: ArrayLike | None = None,
        *,
        altitude_m: tuple[ArrayLike, ArrayLike] | None = None,
        pitch_rad: ArrayLike = 0.0,
        across_first: bool = False,
    ) -> None:
        """Hold headings (n,), horizontal velocities (n, 2), and heights z (n,) or altitudes; see Controller.steer.

        altitude_m: the targets and the measured altitudes.
        """
        n = self.batch.n
        targets = np.full((n, 3), np.nan)
        if altitude_m is not None:
            wanted_m, measured_m = (self._each(one, "altitude_m") for one in altitude_m)
            targets[:, 2] = self._estimates()[0][:, 2] + wanted_m - measured_m
        elif z_world_m is not None:
            targets[:, 2] = self._each(z_world_m, "z_world_m")
        velocities = np.zeros((n, 3))
        velocities[:, :2] = self._rows(velocity_world_m_s, "velocity_world_m_s", 2)
        efforts = self._reached(targets, velocities, heading_rad, 0.0, pitch_rad, across_first=across_first)
        self.batch.set_effort(efforts, self.vehicle)

    def velocity(self, velocity_body: ArrayLike) -> None:
        """Hold velocities (n, 6) in body axes [m/s, rad/s]; see Controller.velocity."""
        wanted = self._rows(velocity_body, "velocity_body", 6)
        self.batch.set_effort(self._core.hold_velocity(*self._estimates(), wanted), self.vehicle)

    def restart(self, mask: ArrayLike | None = None) -> None:
        """Reset integrals and references in all members or those selected by a mask (n,) bool, as after Batch.reset."""
        self._core.restart(arguments.members(mask, self.batch.n))

    def _reached(
        self,
        positions_m: Floats,
        velocities_m_s: Floats,
        heading_rad: ArrayLike,
        roll_rad: ArrayLike,
        pitch_rad: ArrayLike,
        across_first: bool = False,
    ) -> Floats:
        return self._core.reach(
            *self._estimates(),
            positions_m,
            velocities_m_s,
            self._each(roll_rad, "roll_rad"),
            self._each(pitch_rad, "pitch_rad"),
            self._each(heading_rad, "heading_rad"),
            across_first,
        )


class BatchPathFollower(Sealed):
    """A PathFollower of one vehicle in each member; call `steer` once per control period.

    points_m: one path (points, 3) for all members, or n paths. For the other arguments, see PathFollower. Raises
    ValueError.
    """

    controller: BatchController
    speed_m_s: float
    _fixed_when = "the path follower is made"

    def __init__(
        self,
        controller: BatchController,
        points_m: ArrayLike | Sequence[ArrayLike],
        speed_m_s: float,
        *,
        lookahead_m: float = 3.0,
        integral_m_s: float = 0.0,
    ) -> None:
        if not (np.isfinite(speed_m_s) and speed_m_s > 0.0):
            raise ValueError(f"speed_m_s = {speed_m_s} m/s: must be positive")
        n = controller.batch.n
        paths = [np.asarray(path, np.float64) for path in points_m]  # type: ignore[union-attr]
        if all(path.ndim == 1 for path in paths):
            paths = [np.asarray(points_m, np.float64)] * n
        if len(paths) != n:
            raise ValueError(f"points_m: {len(paths)} paths: expected one, or n = {n}")
        self.controller = controller
        self.speed_m_s = float(speed_m_s)
        self._core = _core.BatchPathFollower(paths, lookahead_m, integral_m_s, controller.period_s)

    def __repr__(self) -> str:
        return f"<BatchPathFollower at {self.speed_m_s:g} m/s, by {self.controller!r}>"

    def steer(self) -> BatchGuidance:
        """Set the efforts for one control period. Return the guidance, which shows which members are past the end."""
        positions = self.controller.motion.position_world_m
        rows = self._core.guide(positions, self.speed_m_s, self.controller.force_share)
        course, path, across, along, left, height, is_done = np.ascontiguousarray(rows[:, :7].T)
        heading = path if self.controller.drives_sway else course
        self.controller.steer(heading, rows[:, 7:], height, across_first=True)
        return BatchGuidance(course, path, across, along, left, height, is_done > 0.0)

    def restart(self, mask: ArrayLike | None = None) -> None:
        """Return to the start of each path and restart the controllers, in all members or those selected by a mask."""
        self._core.restart(arguments.members(mask, self.controller.batch.n))
        self.controller.restart(mask)


class BatchAutopilot(_Pilot):
    """An Autopilot of one vehicle in each member; call `steer` once per control period. See BatchController."""

    def __init__(
        self,
        batch: Batch,
        period_s: float = 0.1,
        gains: Gains | None = None,
        *,
        vehicle: str | None = None,
        uses_estimate: bool = False,
    ) -> None:
        super().__init__(batch, period_s, vehicle, uses_estimate=uses_estimate)
        vehicles = [batch.aboard(k).vehicles[self.vehicle] for k in range(batch.n)]
        each = [gains or steady_gains(Gains(), one.authority, period_s) for one in vehicles]
        self._is_idle = np.array([[axis not in one.controllable for axis in AXES] for one in vehicles])
        self._core = _core.BatchAutopilot(period_s, [_core.AutopilotGains(**asdict(own)) for own in each])

    def steer(self, heading_rad: ArrayLike, velocity_world_m_s: ArrayLike, z_world_m: ArrayLike) -> None:
        """Set the efforts for one control period from headings (n,), horizontal velocities (n, 2) and heights (n,)."""
        efforts = self._core.steer(
            *self._estimates(),
            self._each(heading_rad, "heading_rad"),
            self._rows(velocity_world_m_s, "velocity_world_m_s", 2),
            self._each(z_world_m, "z_world_m"),
        )
        efforts[self._is_idle] = 0.0
        self.batch.set_effort(efforts, self.vehicle)

    def restart(self, mask: ArrayLike | None = None) -> None:
        """Reset the integrals, in all members or those selected by a mask (n,) bool, as after Batch.reset."""
        self._core.restart(arguments.members(mask, self.batch.n))
