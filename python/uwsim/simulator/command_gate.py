"""Whether a vehicle's commands take effect: all stop comes before its failsafe, and that before everybody else."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Protocol

import numpy as np

from uwsim.simulator.docking import DockedWarning


class FailsafeWarning(UserWarning):
    """A vehicle has been commanded while its failsafe steers it, so that nothing happens."""


class AllStopWarning(UserWarning):
    """A vehicle has been commanded while all stop is set, so that nothing happens."""


class FailsafeLike(Protocol):
    """What a vehicle knows of its failsafe; see uwsim.simulator.failures.Failsafe."""

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
    """Stands between a vehicle's actuators and every command that moves it.

    vehicle: its name. halt: stops its thrusters and puts its fins to neutral. is_driven: whether the present commands
    would move it. all_stopped: whether all stop is set. stops: how often it has been set; what commands again and again
    by itself ends when this changes. changed: is called when all stop is set or released.
    """

    def __init__(self, vehicle: str, halt: Callable[[], object]) -> None:
        self.failsafe: FailsafeLike | None = None
        self.is_driven = False
        self.all_stopped = False
        self.stops = 0
        self.changed: Callable[[bool], object] = lambda on: None
        self._vehicle = vehicle
        self._halt = halt
        self._warned: set[type[Warning]] = set()

    def all_stop(self, on: bool) -> None:
        """Set all stop, or release it. Raises ValueError."""
        if not isinstance(on, bool | np.bool_):
            raise ValueError(f"all_stop.on = {on!r}: must be True or False")
        self.hears()
        was_on = self.all_stopped
        self.restore(all_stopped=bool(on))
        if was_on != self.all_stopped:
            self.changed(self.all_stopped)

    def restore(self, *, all_stopped: bool) -> None:
        """Continue with or without all stop, and warn again."""
        self.all_stopped = all_stopped
        self._warned.clear()
        if all_stopped:
            self.stops += 1
            self.is_driven = False
            self._halt()

    def require_no_stop(self, command: str) -> None:
        """Raise ValueError for a command that must not be given while all stop is set."""
        if self.all_stopped:
            raise ValueError(f"vehicle '{self._vehicle}': {command}: {STOPPED}")

    def hears(self) -> None:
        """Tell the failsafe that a command comes."""
        if self.failsafe is not None:
            self.failsafe.heard()

    def yields(self, *, moves: bool) -> None:
        """Undo the command that has just been given if all stop is set, or if the failsafe steers. moves: not all 0."""
        failsafe = self.failsafe
        self.is_driven = moves and not self.all_stopped
        if self.all_stopped:
            self._halt()
            if moves and self._warns_first(AllStopWarning):
                warnings.warn(f"vehicle '{self._vehicle}': {STOPPED}", AllStopWarning, stacklevel=3)
        elif failsafe is not None and failsafe.has_control:
            failsafe.insist()
            if self._warns_first(FailsafeWarning):
                warnings.warn(
                    f"vehicle '{self._vehicle}': its failsafe steers ({failsafe.state}: {failsafe.cause}): commands "
                    "have no effect before override_failsafe()",
                    FailsafeWarning,
                    stacklevel=3,
                )

    def warn_of_dock(self) -> None:
        """Warn, once, that the vehicle is commanded in its dock."""
        if self._warns_first(DockedWarning):
            warnings.warn(
                f"vehicle '{self._vehicle}' is docked: its commands have no effect before release(), undock() or "
                "place()",
                DockedWarning,
                stacklevel=5,
            )

    def _warns_first(self, kind: type[Warning]) -> bool:
        """Return whether this is the first warning of its kind since the last restore or change of all stop."""
        is_first = kind not in self._warned
        self._warned.add(kind)
        return is_first

    def override(self) -> None:
        """Take the vehicle back. Raises ValueError if there is no failsafe."""
        if self.failsafe is None:
            raise ValueError(f"vehicle '{self._vehicle}': override_failsafe: it has no failsafe")
        self.failsafe.override()


STOPPED = "all stop is set: nothing moves the vehicle before all_stop(False) releases it"
