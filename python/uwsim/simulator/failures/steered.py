"""A vehicle as seen and steered by its own programs: its failsafe, and its holds."""

from __future__ import annotations

from typing import Any

from uwsim.base.commands import Steerable
from uwsim.navigation.control.protocols import EstimateLike
from uwsim.simulator.onboard_navigation import Use
from uwsim.simulator.vehicle import Vehicle

ZERO = (0.0,) * 6


class Steered(Steerable):
    """A vehicle steered by its own failsafe; unlike external commands, its efforts are not logged.

    pose, velocity: estimated from the vehicle's own instruments (Vehicle.estimate) once something has steered by them;
    until then, the true values.
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
        """The pose known to the vehicle."""
        return self._known.pose

    @property
    def velocity(self) -> Any:
        """The velocity known to the vehicle."""
        return self._known.velocity

    @property
    def _known(self) -> EstimateLike:
        navigation = self._vehicle.navigation
        return navigation.steering if navigation.is_begun(Use.STEERING) else self._vehicle

    def command(self, name: str, /, **efforts: float) -> None:
        """Set efforts, clipped to [-1, 1]; no other command is supported."""
        self.last = tuple(efforts.values())
        self.insist()

    def insist(self) -> None:
        """Reapply the last efforts."""
        self._vehicle.steer_silently(self.last)


class Aided(Steered):
    """A vehicle that adds the efforts of its holds to the stick's, on axes where the stick is at rest.

    held: the indices of the axes that holds steer.
    """

    def __init__(self, vehicle: Vehicle) -> None:
        super().__init__(vehicle)
        self.stick: tuple[float, ...] = ZERO
        self.held: frozenset[int] = frozenset()

    def insist(self) -> None:
        """Apply the stick and the holds."""
        self._vehicle.steer_silently(
            [s if s or k not in self.held else h for k, (s, h) in enumerate(zip(self.stick, self.last, strict=True))]
        )
