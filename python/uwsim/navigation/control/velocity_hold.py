"""Velocity control in body axes, for individual commands such as /cmd_vel."""

from __future__ import annotations

from uwsim.base.arrays import Floats
from uwsim.base.axes import AXES
from uwsim.base.sealed import Sealed
from uwsim.navigation.control.controller import Controller, ControlSettingsLike
from uwsim.navigation.control.protocols import SteeredVehicle


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
