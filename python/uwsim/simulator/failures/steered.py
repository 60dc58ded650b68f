"""A vehicle as seen and steered by its own failsafe."""

from __future__ import annotations

from typing import Any

from uwsim.commands import Steerable
from uwsim.navigation.control.protocols import EstimateLike
from uwsim.simulator.vehicle import Vehicle

ZERO = (0.0,) * 6


class Steered(Steerable):
    """A vehicle steered by its own failsafe; unlike commands from outside, its efforts are not logged.

    pose, velocity: from the vehicle's own instruments (Vehicle.estimate) once its navigation has begun; the truth
    before.
    """

    def __init__(self, vehicle: Vehicle) -> None:
        self._vehicle = vehicle
        self.last: tuple[float, ...] = ZERO

    @property
    def authority(self) -> Any:
        """The vehicle's authority."""
        return self._vehicle.authority

    @property
    def pose(self) -> Any:
        """The pose as the vehicle knows it."""
        return self._known.pose

    @property
    def velocity(self) -> Any:
        """The velocity as the vehicle knows it."""
        return self._known.velocity

    @property
    def _known(self) -> EstimateLike:
        navigation = self._vehicle.navigation
        return navigation.navigator if navigation.has_begun else self._vehicle

    def command(self, name: str, /, **efforts: float) -> None:
        """Set efforts, clipped to [-1, 1]; the only command."""
        self.last = tuple(efforts.values())
        self.insist()

    def insist(self) -> None:
        """Set the last efforts again."""
        self._vehicle.steer_silently(self.last)
