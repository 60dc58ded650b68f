"""A cascaded controller with a vehicle model, which holds positions, courses and velocities."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.axes import AXES
from uwsim.base.sealed import Sealed
from uwsim.navigation.control.autopilot import Autopilot
from uwsim.navigation.control.protocols import EstimateLike, SteeredVehicle

Efforts = tuple[float, float, float, float, float, float]
STILL = np.zeros(3)


class ControlSettingsLike(Protocol):
    """A vehicle's model and gains; see uwsim.scenario.control_settings."""

    @property
    def model(self) -> _core.ControlModel:
        """The equations of motion and the actuator limits."""

    @property
    def gains(self) -> _core.ControlGains:
        """The gains and limits of the control loops."""


class Controller(Sealed):
    """Converts targets to efforts. Call `hold`, `steer` or `velocity` once per control period.

    estimate: the source of the vehicle's motion; defaults to the vehicle itself, which provides the true motion if it
    is simulated. settings: the model and gains from the vehicle file; defaults to `vehicle.control`. For a remote
    vehicle, which has no `control`, pass `uwsim.scenario.control_settings("bluerov2_heavy")`. The control law is in
    cpp/uwsim/control/motion_controller.h; see also docs/guides/control.md. Axes without actuators are not controlled.
    """

    vehicle: SteeredVehicle
    estimate: EstimateLike
    period_s: float
    _fixed_when = "the controller is made"

    def __init__(
        self,
        vehicle: SteeredVehicle,
        period_s: float = 0.05,
        *,
        settings: ControlSettingsLike | None = None,
        estimate: EstimateLike | None = None,
    ) -> None:
        if settings is None and (settings := getattr(vehicle, "control", None)) is None:
            raise ValueError("settings = None: the vehicle has no `control`; pass uwsim.scenario.control_settings(...)")
        self.vehicle = vehicle
        self.estimate = vehicle if estimate is None else estimate
        self.period_s = period_s
        self._sway = settings.model.driven[1]
        self._core = _core.MotionController(settings.model, settings.gains, period_s)

    def __repr__(self) -> str:
        return f"<Controller of {self.vehicle!r}, every {self.period_s:g} s>"

    @property
    def drives_sway(self) -> bool:
        """Whether the vehicle can move sideways."""
        return self._sway

    def hold(
        self,
        position_world_m: Sequence[float] | Floats,
        heading_rad: float,
        *,
        roll_rad: float = 0.0,
        pitch_rad: float = 0.0,
        velocity_world_m_s: Sequence[float] | Floats = STILL,
    ) -> None:
        """Go to a position (3,) and attitude, and hold them. velocity_world_m_s: velocity (3,) of a moving position."""
        efforts = self._reach(position_world_m, velocity_world_m_s, heading_rad, roll_rad, pitch_rad)
        self.vehicle.set_effort(*efforts)

    def hold_efforts(self, position_world_m: Sequence[float] | Floats, heading_rad: float) -> Efforts:
        """Return the efforts that `hold` would set to keep a place."""
        return self._reach(position_world_m, STILL, heading_rad)

    def steer(
        self,
        heading_rad: float,
        velocity_world_m_s: Sequence[float] | Floats,
        z_world_m: float | None = None,
        *,
        altitude_m: tuple[float, float] | None = None,
        pitch_rad: float = 0.0,
        across_first: bool = False,
    ) -> None:
        """Hold a heading, a horizontal velocity over ground (2,), and either a height z or an altitude.

        altitude_m: target and measured altitude. Without z_world_m and altitude_m, the vertical velocity is held at
        zero, and a vehicle without vertical thrust holds its pitch instead. pitch_rad: positive nose down.
        across_first: whether lateral force has priority over longitudinal force if the thrust is insufficient.
        """
        self.vehicle.set_effort(
            *self.steer_efforts(
                heading_rad,
                velocity_world_m_s,
                z_world_m,
                altitude_m=altitude_m,
                pitch_rad=pitch_rad,
                across_first=across_first,
            )
        )

    def steer_efforts(
        self,
        heading_rad: float,
        velocity_world_m_s: Sequence[float] | Floats,
        z_world_m: float | None = None,
        *,
        altitude_m: tuple[float, float] | None = None,
        pitch_rad: float = 0.0,
        across_first: bool = False,
    ) -> Efforts:
        """Return the efforts that `steer` would set."""
        if altitude_m is not None:
            wanted_m, measured_m = altitude_m
            z_world_m = float(self.estimate.pose.position_world_m[2]) + wanted_m - measured_m
        east, north = velocity_world_m_s
        z_m = math.nan if z_world_m is None else z_world_m
        free = math.nan
        return self._reach(
            (free, free, z_m), (east, north, 0.0), heading_rad, 0.0, pitch_rad, across_first=across_first
        )

    def velocity(self, velocity_body: Sequence[float] | Floats) -> None:
        """Hold a velocity (6,) in body axes [m/s, rad/s], and stay level unless a rate about x or y is commanded."""
        self.vehicle.set_effort(*self.velocity_efforts(velocity_body))

    def velocity_efforts(self, velocity_body: Sequence[float] | Floats) -> Efforts:
        """Return the efforts that `velocity` would set."""
        estimate = self.estimate
        return self._core.hold_velocity(estimate.pose, estimate.velocity, np.asarray(velocity_body, np.float64))

    @property
    def force_share(self) -> float:
        """The fraction of the required force that the thrusters produced last period; below 1 at their limit."""
        return self._core.force_share

    @property
    def memory(self) -> Floats:
        """The state kept between periods, (25,): integrals, references and filters, for saving and restoring."""
        return self._core.memory

    @memory.setter
    def memory(self, memory: Sequence[float] | Floats) -> None:
        self._core.memory = np.asarray(memory, np.float64)

    def _reach(
        self,
        position_world_m: Sequence[float] | Floats,
        velocity_world_m_s: Sequence[float] | Floats,
        heading_rad: float,
        roll_rad: float = 0.0,
        pitch_rad: float = 0.0,
        across_first: bool = False,
    ) -> Efforts:
        estimate = self.estimate
        return self._core.reach(
            estimate.pose,
            estimate.velocity,
            np.asarray(position_world_m, np.float64),
            np.asarray(velocity_world_m_s, np.float64),
            roll_rad,
            pitch_rad,
            heading_rad,
            across_first,
        )


Pilot = Autopilot | Controller


def survey_pilot(vehicle: SteeredVehicle, period_s: float) -> Pilot:
    """Return a pilot for a vehicle, to be called once every period_s.

    Thrusters that push below the centre of mass pitch the vehicle and saturate together. An Autopilot, which does not
    model this, made a BlueROV2 Heavy pitch over after 15 s of the lake survey at 1.4 m/s; a Controller models it. A
    vehicle without thrusters receives exactly the commanded wrench; for it, the Autopilot, which does not plan
    accelerations, is 2 % faster and covers 2 % more.
    """
    settings = getattr(vehicle, "control", None)
    if settings is not None and getattr(settings, "thrusters", 0) > 0:
        return Controller(vehicle, period_s, settings=settings)
    return Autopilot(vehicle, period_s)


class VelocityHold(Sealed):
    """Converts a commanded velocity to efforts with the loops of `Controller`. Call `efforts` once per control period.

    The vehicle is kept level in roll and pitch unless a rate about either is commanded.
    """

    controller: Controller
    _fixed_when = "the controller is made"

    def __init__(self, vehicle: SteeredVehicle, period_s: float, settings: ControlSettingsLike | None = None) -> None:
        self.controller = Controller(vehicle, period_s, settings=settings)

    def efforts(self, velocity_body: Floats) -> dict[str, float]:
        """Return this period's efforts for a velocity (6,), [m/s] and [rad/s], keyed by axis, each in [-1, 1]."""
        return dict(zip(AXES, self.controller.velocity_efforts(velocity_body), strict=True))
