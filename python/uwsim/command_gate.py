"""Whether a vehicle's commands take effect: its failsafe hears of each, and may have the controls."""

from __future__ import annotations

import warnings
from typing import Protocol


class FailsafeWarning(UserWarning):
    """A vehicle has been commanded while its failsafe steers it, so that nothing happens."""


class FailsafeLike(Protocol):
    """What a vehicle knows of its failsafe; see uwsim.failures.Failsafe."""

    @property
    def state(self) -> str:
        """What it does."""

    @property
    def cause(self) -> str:
        """Why it does so."""

    @property
    def alarms(self) -> tuple[str, ...]:
        """What it notices, in words."""

    @property
    def has_control(self) -> bool:
        """Whether it steers, and commands have no effect."""

    def heard(self) -> None:
        """Take note of a command."""

    def insist(self) -> None:
        """Set its last efforts again."""

    def override(self) -> None:
        """Give the vehicle back."""


class CommandGate:
    """Stands between a vehicle's commands and its failsafe, if it has one. vehicle: its name."""

    def __init__(self, vehicle: str) -> None:
        self.failsafe: FailsafeLike | None = None
        self._vehicle = vehicle
        self._has_warned = False

    def hears(self) -> None:
        """Tell the failsafe that a command comes."""
        if self.failsafe is not None:
            self.failsafe.heard()

    def yields(self) -> None:
        """Let the failsafe's efforts stand if it steers: the command that has just been given has no effect."""
        failsafe = self.failsafe
        if failsafe is None or not failsafe.has_control:
            return
        failsafe.insist()
        if not self._has_warned:
            self._has_warned = True
            warnings.warn(
                f"vehicle '{self._vehicle}': its failsafe steers ({failsafe.state}: {failsafe.cause}): commands have "
                "no effect before override_failsafe()",
                FailsafeWarning,
                stacklevel=3,
            )

    def override(self) -> None:
        """Take the vehicle back. Raises ValueError if there is no failsafe."""
        if self.failsafe is None:
            raise ValueError(f"vehicle '{self._vehicle}': override_failsafe: it has no failsafe")
        self.failsafe.override()
