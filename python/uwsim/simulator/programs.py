"""The interfaces of the programs aboard that steer a vehicle: its failsafe and its holds."""

from __future__ import annotations

from typing import Protocol


class FailsafeLike(Protocol):
    """The interface of a vehicle's failsafe; see uwsim.simulator.failures.Failsafe."""

    @property
    def state(self) -> str:
        """The failsafe's current reaction."""

    @property
    def cause(self) -> str:
        """The cause of the reaction."""

    @property
    def alarms(self) -> tuple[str, ...]:
        """The active alarms, as text."""

    @property
    def is_steering(self) -> bool:
        """True while the reaction moves the vehicle."""

    @property
    def has_control(self) -> bool:
        """True while the failsafe steers, so that commands have no effect."""

    def note_command(self) -> None:
        """Register a command."""

    def insist(self) -> None:
        """Reapply the failsafe's last efforts."""

    def override(self) -> None:
        """Return control of the vehicle."""


class HoldsLike(Protocol):
    """The interface of a vehicle's holds; see uwsim.simulator.holds.Holds."""

    targets: dict[str, list[float] | None]
    note: str

    @property
    def possible(self) -> list[str]:
        """The names of the holds for which the vehicle has actuators and sensors."""

    @property
    def has_control(self) -> bool:
        """True while any hold is active."""

    def set(self, **on: bool) -> None:
        """Activate exactly these holds."""

    def take(self, efforts: tuple[float, ...]) -> None:
        """Apply a stick's efforts."""

    def end(self, why: str) -> None:
        """End all holds."""
