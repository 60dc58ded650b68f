"""Aided: combines a pilot's stick with the efforts of holds."""

from __future__ import annotations

from uwsim.simulator.failures.steered import ZERO, Steered
from uwsim.simulator.vehicle import Vehicle


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
