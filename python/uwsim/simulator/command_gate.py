"""Decides whether a vehicle's commands take effect: all stop overrides the failsafe, and both override the rest."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable
from typing import Protocol

import numpy as np

from uwsim.simulator.docking import DockedWarning


class FailsafeWarning(UserWarning):
    """Issued when a vehicle is commanded while its failsafe is steering: the command has no effect."""


class IdleAxisWarning(UserWarning):
    """Issued once for each axis when an effort is commanded on an axis that no thruster, fin or force drives."""


class AllStopWarning(UserWarning):
    """Issued when a vehicle is commanded while all stop is set: the command has no effect."""


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
    def has_control(self) -> bool:
        """Whether the failsafe is steering, so that commands have no effect."""

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


class CommandGate:
    """Filters every command that moves a vehicle before it reaches the actuators.

    vehicle: its name. halt: stops its thrusters and centres its fins. is_driven: whether the current commands would
    move it. all_stopped: whether all stop is set. stops: how many times all stop has been set; a program that issues
    periodic commands ends when this number changes. changed: called when all stop is set or released. note:
    logs a note. autopilot: the program that steers the vehicle step by step, if any.
    """

    def __init__(self, vehicle: str, halt: Callable[[], object]) -> None:
        self.failsafe: FailsafeLike | None = None
        self.holds: HoldsLike | None = None
        self.is_driven = False
        self.all_stopped = False
        self.autopilot = ""
        self.stops = 0
        self.changed: Callable[[bool], object] = lambda on: None
        self.note: Callable[..., object] = lambda **values: None
        self._vehicle = vehicle
        self._halt = halt
        self._warned: set[type[Warning]] = set()
        self._idle_named: set[str] = set()

    def all_stop(self, on: bool) -> None:
        """Set or release all stop. Raises ValueError unless `on` is a bool."""
        if not isinstance(on, bool | np.bool_):
            raise ValueError(f"all_stop.on = {on!r}: must be True or False")
        self.note_command()
        was_on = self.all_stopped
        self.restore(all_stopped=bool(on))
        if was_on != self.all_stopped:
            self.changed(self.all_stopped)

    def restore(self, *, all_stopped: bool) -> None:
        """Restore the all-stop state, and let each warning be issued once more."""
        self.all_stopped = all_stopped
        self._warned.clear()
        if all_stopped:
            self.stops += 1
            self.is_driven = False
            self.end_holds("all stop")
            self._halt()

    def require_no_stop(self, command: str) -> None:
        """Raise ValueError for a command that must not be issued while all stop is set."""
        if self.all_stopped:
            raise ValueError(f"vehicle '{self._vehicle}': {command}: {STOPPED}")

    def require_no_autopilot(self, command: str) -> None:
        """Raise ValueError for a command that would move a vehicle steered by an autopilot."""
        if self.autopilot:
            raise ValueError(f"vehicle '{self._vehicle}': {command}: has no effect while {self.autopilot} steers")

    def admits_autopilot(self) -> bool:
        """Return whether an autopilot's outputs move the vehicle; if so, end the holds."""
        if self.all_stopped or (self.failsafe is not None and self.failsafe.has_control):
            return False
        self.end_holds("an autopilot steers")
        return True

    def notice_autopilot(self) -> None:
        """Notify the failsafe of an autopilot's outputs."""
        if self.failsafe is not None:
            self.failsafe.note_command()

    def note_command(self) -> None:
        """Notify the failsafe of a command."""
        if self.failsafe is not None:
            self.failsafe.note_command()

    def end_holds(self, why: str) -> None:
        """End the holds, if any."""
        if self.holds is not None and self.holds.has_control:
            self.holds.end(why)

    def yields(self, *, moves: bool, stick: tuple[float, ...] | None = None) -> None:
        """Override the command just issued if all stop is set or the failsafe is steering; otherwise combine holds.

        moves: whether any commanded value is nonzero. stick: the commanded efforts, alongside which holds stay active;
        None for other kinds of command, which end holds.
        """
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
        elif self.holds is not None and self.holds.has_control:
            if stick is None:
                self.holds.end("another command steers")
            else:
                self.is_driven = True
                self.holds.take(stick)

    def warn_of_dock(self) -> None:
        """Warn, once, that the vehicle is being commanded while docked."""
        if self._warns_first(DockedWarning):
            warnings.warn(
                f"vehicle '{self._vehicle}' is docked: its commands have no effect before release(), undock() or "
                "place()",
                DockedWarning,
                stacklevel=5,
            )

    def warn_of_idle(self, axes: Iterable[str], controllable: Iterable[str]) -> None:
        """Warn, once for each axis, of efforts on axes that nothing drives."""
        new = [axis for axis in axes if axis not in self._idle_named]
        if new:
            self._idle_named.update(new)
            warnings.warn(
                f"vehicle '{self._vehicle}': effort on {', '.join(new)}: has no effect, since nothing drives it; it "
                f"drives {', '.join(controllable) or 'nothing'}",
                IdleAxisWarning,
                stacklevel=4,
            )

    def _warns_first(self, kind: type[Warning]) -> bool:
        """Return whether this is the first warning of its kind since the last restore or all-stop change."""
        is_first = kind not in self._warned
        self._warned.add(kind)
        return is_first

    def override(self) -> None:
        """Take back control from the failsafe. Raises ValueError if the vehicle has no failsafe."""
        if self.failsafe is None:
            raise ValueError(f"vehicle '{self._vehicle}': override_failsafe: it has no failsafe")
        self.failsafe.override()


STOPPED = "all stop is set: nothing moves the vehicle before all_stop(False) releases it"
