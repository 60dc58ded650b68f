"""The vehicle as its own failsafe steers it."""

from __future__ import annotations

from typing import Any

from uwsim.control.protocols import EstimateLike
from uwsim.vehicle import Vehicle

ZERO = (0.0,) * 6


class Steered:
    """The vehicle as its own failsafe steers it: unlike commands from outside, its efforts are not noted.

    pose, velocity: by its own instruments (Vehicle.estimate) once its navigation has begun; the truth before.
    """

    def __init__(self, vehicle: Vehicle) -> None:
        self._vehicle = vehicle
        self.last: tuple[float, ...] = ZERO

    @property
    def authority(self) -> Any:
        """The vehicle's."""
        return self._vehicle.authority

    @property
    def pose(self) -> Any:
        """As far as the vehicle knows."""
        return self._known.pose

    @property
    def velocity(self) -> Any:
        """As far as the vehicle knows."""
        return self._known.velocity

    @property
    def _known(self) -> EstimateLike:
        navigation = self._vehicle.navigation
        return navigation.navigator if navigation.has_begun else self._vehicle

    def set_effort(
        self,
        surge: float = 0.0,
        sway: float = 0.0,
        heave: float = 0.0,
        roll: float = 0.0,
        pitch: float = 0.0,
        yaw: float = 0.0,
    ) -> None:
        """Set efforts, saturated."""
        self.last = (surge, sway, heave, roll, pitch, yaw)
        self.insist()

    def insist(self) -> None:
        """Set the last efforts again."""
        self._vehicle.steer_silently(self.last)
