"""Helm: decides who steers a vehicle, and what becomes of everybody else's commands.

All that moves a vehicle is a `Source`, and takes the helm before it commands. These tables contain all the rules; they
are defined only here. tests/python/simulator/test_helm.py reads the first two, and tries every cell on a simulator.

Who may take the helm:

| who steers  | `CLIENT` | `FLIGHT` | `PILOT` | `AUTOPILOT` | `FAILSAFE` | `ALL_STOP` |
|-------------|----------|----------|---------|-------------|------------|------------|
| none        | takes    | takes    | takes   | takes       | takes      | takes      |
| `HOLD`      | takes    | takes    | takes   | takes       | takes      | takes      |
| `CLIENT`    | takes    | takes    | takes   | takes       | takes      | takes      |
| `FLIGHT`    | takes    | takes    | takes   | takes       | takes      | takes      |
| `PILOT`     | refused  | refused  | takes   | takes       | takes      | takes      |
| `AUTOPILOT` | refused  | refused  | waits   | takes       | takes      | takes      |
| `FAILSAFE`  | waits    | waits    | waits   | waits       | takes      | takes      |
| `ALL_STOP`  | refused  | refused  | waits   | waits       | waits      | takes      |

Up to `FLIGHT`, the last source to command takes the helm from the others; from `PILOT` upwards, each outranks those
before it. Waits: it steers as soon as those above it have ended. Any client may set all stop. Pilots and flights bind
the doors through which commands of others arrive (topics, services, ground stations), not the program that runs the
simulator itself. A plan that a pilot flies at the station counts as the pilot.

What becomes of a command that reaches the vehicle:

| who steers  | `set_effort` | another command | a command that stops | `hold`  | `place` |
|-------------|--------------|-----------------|----------------------|---------|---------|
| none        | steers       | steers          | steers               | steers  | places  |
| `HOLD`      | joins        | steers          | steers               | steers  | places  |
| `AUTOPILOT` | refused      | refused         | stops                | refused | places  |
| `FAILSAFE`  | overridden   | overridden      | overridden           | refused | places  |
| `ALL_STOP`  | overridden   | overridden      | overridden           | refused | places  |

Another command: `set_wrench`, `set_thrusters`, `set_fins`. A command that stops has zeros only; of them, `set_effort`
joins holds as well. Joins: the holds go on where the effort is zero. Stops: until the autopilot's next frame. Refused:
ValueError, and nothing has changed. Overridden: it is journalled, but has no effect, of which one warning informs.
`place` is an act on the world, not a way to steer: it only ends holds. `release` and `undock` are refused by all stop
alone.

What becomes of a source that falls silent (`Timeout`):

| who is silent       | by the clock | for                   | then                                         |
|---------------------|--------------|-----------------------|----------------------------------------------|
| a topic's publisher | `SIMULATED`  | `command_timeout_s`   | its command ends                             |
| a pilot's efforts   | `WALL`       | 0.5 s                 | they are set to zero                         |
| a pilot's speed hold| `WALL`       | 1.5 s                 | it ends                                      |
| a MAVLink station   | `WALL`       | FS_GCS_TIMEOUT        | it loses the sticks, and FS_GCS_ENABLE acts  |
| an autopilot        | `LOCKSTEP`   | `patience_s`          | `step` raises an error; a live world waits   |
| all of them         | `SIMULATED`  | `failsafe: silence_s` | the failsafe steers, until the next command  |
"""

from __future__ import annotations

import math
import threading
import warnings
from collections.abc import Callable, Iterable
from enum import Enum, IntEnum, StrEnum
from typing import TypeVar

import numpy as np

from uwsim.simulator.docking import DockedWarning
from uwsim.simulator.programs import FailsafeLike, HoldsLike

T = TypeVar("T")


class Source(IntEnum):
    """The sources of commands, by rank. FLIGHT: an action. AUTOPILOT: a program that makes the simulator's steps."""

    NONE = 0
    HOLD = 1
    CLIENT = 2
    FLIGHT = 3
    PILOT = 4
    AUTOPILOT = 5
    FAILSAFE = 6
    ALL_STOP = 7


class Reason(StrEnum):
    """Why a source has lost the helm."""

    REPLACED = "another command steers"
    PILOT = "the pilot has the controls"
    AUTOPILOT = "an autopilot steers"
    FAILSAFE = "the failsafe steers"
    ALL_STOP = "all stop"
    DOCKED = "the vehicle is docked"
    PLACED = "the vehicle was placed elsewhere"


LOST_TO = {Source.PILOT: Reason.PILOT, Source.AUTOPILOT: Reason.AUTOPILOT}
"""The reason of those that lose the helm to a source; otherwise REPLACED."""
STOPPED = "all stop is set: nothing moves the vehicle before all_stop(False) releases it"


class FailsafeWarning(UserWarning):
    """Issued when a vehicle is commanded while its failsafe is steering: the command has no effect."""


class IdleAxisWarning(UserWarning):
    """Issued once for each axis when an effort is commanded on an axis that no thruster, fin or force drives."""


class AllStopWarning(UserWarning):
    """Issued when a vehicle is commanded while all stop is set: the command has no effect."""


class Clock(Enum):
    """The clock by which a source's silence is measured.

    SIMULATED: simulated time, which a pause stops, for commands that a program publishes. WALL: wall time, for a person
    at a page. LOCKSTEP: wall time while the simulated time waits for the source, as for an autopilot's next frame.
    """

    SIMULATED = "simulated time"
    WALL = "wall time"
    LOCKSTEP = "wall time while the simulation waits"


class Timeout:
    """The time for which a source may be silent.

    clock: what measures it. limit_s: returns the limit [s], or 0 for none. then: to be called once the source has
    fallen silent. heard_ns: when it was last heard.
    """

    def __init__(
        self,
        clock: Clock,
        limit_s: Callable[[], float],
        then: Callable[[], object] = lambda: None,
        heard_ns: float = -math.inf,
    ) -> None:
        self.clock, self.limit_s, self.then, self.heard_ns = clock, limit_s, then, heard_ns

    def left_ns(self, now_ns: int) -> float:
        """Return the time until the source counts as silent; 0 if it does. A time after now is from before a reset."""
        limit_s = self.limit_s()
        if not 0 < limit_s < math.inf:
            return math.inf
        return max(self.heard_ns + round(1e9 * limit_s) - now_ns, 0) if self.heard_ns <= now_ns else 0


class Lease:
    """The helm as one source has taken it, until it ends the lease or loses it; see Helm.take.

    lose: called by Helm, with the reason. driver: the kind of client that renews it, such as "a rosbridge client", or
    "". timeout: the silence after which it no longer counts as renewed, if that is limited.
    """

    def __init__(self, helm: Helm, source: Source, name: str, lose: Callable[[Reason], object]) -> None:
        self._helm, self.source, self.name, self.lose = helm, source, name, lose
        self.driver = ""
        self.timeout: Timeout | None = None

    @property
    def is_held(self) -> bool:
        """True until the lease is ended or lost."""
        return self in self._helm.leases

    def give(self, command: Callable[[], T]) -> T:
        """Issue a command and return its result. Raises RuntimeError if the lease is no longer held."""
        with self._helm.lock:
            if not self.is_held:
                raise RuntimeError(self._helm.refusal(self.source) or Reason.REPLACED)
            return command()

    def end(self) -> bool:
        """Return the helm; return whether the lease was held."""
        with self._helm.lock:
            was_held = self.is_held
            self._helm.leases = tuple(each for each in self._helm.leases if each is not self)
        return was_held


class Helm:
    """The helm of one vehicle.

    vehicle: its name. halt: stops its thrusters and centres its fins. is_driven: whether the current commands would
    move it. all_stopped: whether all stop is set. changed: called when all stop is set or released. note: logs a note.
    leases: those held now. lock: held while leases change; a door holds it while it both checks and queues a command.
    Leases may be taken and ended on any thread; the rest is for the stepping thread.
    """

    def __init__(self, vehicle: str, halt: Callable[[], object]) -> None:
        self.failsafe: FailsafeLike | None = None
        self.holds: HoldsLike | None = None
        self.is_driven = False
        self.all_stopped = False
        self.changed: Callable[[bool], object] = lambda on: None
        self.note: Callable[..., object] = lambda **values: None
        self.leases: tuple[Lease, ...] = ()
        self.lock = threading.RLock()
        self._vehicle = vehicle
        self._halt = halt
        self._warned: set[type[Warning]] = set()
        self._idle_named: set[str] = set()

    # Who steers

    @property
    def steers(self) -> Source:
        """The source that steers: the highest of those that have taken the helm."""
        if self.all_stopped:
            return Source.ALL_STOP
        if self.failsafe is not None and self.failsafe.has_control:
            return Source.FAILSAFE
        if self.leases:
            return max(lease.source for lease in self.leases)
        return Source.HOLD if self.holds is not None and self.holds.has_control else Source.NONE

    def refusal(self, source: Source) -> str:
        """Return the reason why a source may not move the vehicle now, or ""."""
        steers = self.steers
        if steers <= source or steers < Source.PILOT:
            return ""
        if steers is Source.ALL_STOP:
            return STOPPED
        if steers is Source.FAILSAFE and self.failsafe is not None:
            return f"its failsafe steers ({self.failsafe.state}: {self.failsafe.cause})"
        if steers is Source.AUTOPILOT:
            return f"has no effect while {self.name_of(steers)} steers"
        return f"{self.name_of(steers)} has the controls, at the operator's station"

    def name_of(self, source: Source) -> str:
        """Return the name under which a source holds a lease, or ""."""
        return next((lease.name for lease in self.leases if lease.source is source), "")

    def require(self, what: str, source: Source = Source.PILOT) -> None:
        """Raise ValueError for something that a source may not do to the vehicle now, with the reason."""
        if why := self.refusal(source):
            raise ValueError(f"vehicle '{self._vehicle}': {what}: {why}")

    def admits(self, source: Source) -> bool:
        """Return whether a source's commands may reach the vehicle. A failsafe admits them, to override them."""
        return self.steers is Source.FAILSAFE or not self.refusal(source)

    def require_at_door(self, what: str, source: Source) -> None:
        """Raise ValueError for a command of a source that must not reach the vehicle."""
        if not self.admits(source):
            self.require(what, source)

    def take(
        self,
        source: Source,
        name: str,
        lose: Callable[[Reason], object] = lambda reason: None,
        *,
        beside: tuple[str, ...] = (),
    ) -> Lease:
        """Take the helm, or wait for it; return the lease. Raises ValueError, changing nothing, if it is refused.

        Sources below PILOT, and another of the same kind, lose their leases. name: such as "ArduSub". lose: called with
        the reason, on any thread, when the lease is lost. It must not block. beside: endings of names of leases that
        remain.
        """
        lease = Lease(self, source, name, lose)
        with self.lock:
            if source < Source.PILOT:
                self.require_at_door(name, source)
            self._pass(source, LOST_TO.get(source, Reason.REPLACED), beside, lease)
        return lease

    def clear(self, reason: Reason, *, beside: tuple[str, ...] = ()) -> None:
        """End the leases of all sources below PILOT. beside: as in `take`."""
        with self.lock:
            self._pass(Source.CLIENT, reason, beside)

    def _pass(self, source: Source, reason: Reason, beside: tuple[str, ...], *heirs: Lease) -> None:
        """End the leases that a source takes over, and add those of the heirs."""
        taken = [each for each in self.leases if each.source < Source.PILOT or each.source is source]
        lost = [each for each in taken if not each.name.endswith(beside)]
        self.leases = (*(each for each in self.leases if each not in lost), *heirs)
        for each in lost:
            each.lose(reason)

    # All stop and failsafe

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
            self.is_driven = False
            self.clear(Reason.ALL_STOP)
            self.end_holds(Reason.ALL_STOP)
            self._halt()

    def override(self) -> None:
        """Take back control from the failsafe. Raises ValueError if the vehicle has no failsafe."""
        if self.failsafe is None:
            raise ValueError(f"vehicle '{self._vehicle}': override_failsafe: it has no failsafe")
        self.failsafe.override()

    # Commands

    def admit(self, command: str, *, moves: bool) -> None:
        """Register a command that is about to take effect; see `settle`.

        moves: whether any commanded value is nonzero. Raises ValueError if it would move a vehicle that an autopilot
        steers.
        """
        if moves and self.leases and self.steers is Source.AUTOPILOT:
            self.require(command)
        if self.failsafe is not None:
            self.failsafe.note_command()

    def settle(self, *, moves: bool, stick: tuple[float, ...] | None = None) -> None:
        """Override the command just issued if all stop is set or the failsafe is steering; otherwise combine holds.

        moves: whether any commanded value is nonzero. stick: the commanded efforts, alongside which holds stay active;
        None for other kinds of command, which end holds.
        """
        failsafe = self.failsafe
        self.is_driven = moves and not self.all_stopped
        if self.all_stopped:
            self._halt()
            if moves:
                self._warn_once(AllStopWarning, f": {STOPPED}")
        elif failsafe is not None and failsafe.has_control:
            failsafe.insist()
            self._warn_once(
                FailsafeWarning, f": {self.refusal(Source.PILOT)}: commands have no effect before override_failsafe()"
            )
        elif self.holds is not None and self.holds.has_control:
            if stick is None:
                self.holds.end(Reason.REPLACED)
            else:
                self.is_driven = True
                self.holds.take(stick)

    def admit_frames(self) -> bool:
        """Return whether an autopilot's frames move the vehicle; if so, end the holds."""
        if self.refusal(Source.AUTOPILOT):
            return False
        self.end_holds(Reason.AUTOPILOT)
        return True

    def end_holds(self, why: Reason) -> None:
        """End the holds, if any."""
        if self.holds is not None and self.holds.has_control:
            self.holds.end(why)

    @property
    def is_watched(self) -> bool:
        """True if all stop, a failsafe or a hold may change the effect of a command."""
        has_holds = self.holds is not None and self.holds.has_control
        return self.all_stopped or self.failsafe is not None or has_holds

    def note_command(self) -> None:
        """Register a command or an autopilot's frames with the failsafe, whose silence they end."""
        if self.failsafe is not None:
            self.failsafe.note_command()

    # Warnings

    def warn_of_dock(self) -> None:
        """Warn, once, that the vehicle is being commanded while docked."""
        self._warn_once(
            DockedWarning, " is docked: its commands have no effect before release(), undock() or place()", stacklevel=6
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

    def _warn_once(self, kind: type[Warning], text: str, stacklevel: int = 4) -> None:
        """Issue the first warning of its kind since the last restore or all-stop change."""
        if kind not in self._warned:
            self._warned.add(kind)
            warnings.warn(f"vehicle '{self._vehicle}'{text}", kind, stacklevel=stacklevel)
