"""The steps of a simulator whose vehicles are flown by ArduSubs: one when a frame of each is in."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, Self

from uwsim import _core
from uwsim.simulator.lockstep import FRAME_BYTES

if TYPE_CHECKING:
    from uwsim.bridges.ardusub.auxiliary import Auxiliary
    from uwsim.simulator.simulator import Simulator
    from uwsim.simulator.vehicle import Vehicle

LIVE_PATIENCE_S = 0.05  # longest time for which a live simulator's thread waits for a frame
STEPS_AT_ONCE = 2000


class Partner(Protocol):
    """An autopilot and its vehicle; see ArduSub."""

    vehicle: str
    auxiliary: Auxiliary
    patience_s: float

    @property
    def flown(self) -> Vehicle:
        """The vehicle."""

    @property
    def exchange(self) -> _core.ServoExchange:
        """The exchange of packets."""

    @property
    def is_live(self) -> bool:
        """True if the simulator is a live one."""

    def take(self, frames: bytes, tick: int, *, changed: bool) -> None:
        """Note the frames that made steps from a tick on."""

    def note_missing(self) -> None:
        """Note that no step could be made."""


class ServoSteps:
    """A source of steps: all autopilots of a simulator, in the order of its vehicles."""

    def __init__(self, sim: Simulator) -> None:
        self._sim = sim
        self._flown: list[Partner] = []

    @classmethod
    def of(cls, sim: Simulator) -> Self:
        """Return a simulator's present source, or a new one. Raises ValueError if it is of another kind."""
        source = cls(sim) if sim.lockstep.is_free else sim.lockstep.source
        if not isinstance(source, cls):
            raise ValueError("recorded frames make the steps of this simulator")
        return source

    def require_free(self, vehicle: str) -> None:
        """Raise ValueError if an autopilot flies this vehicle already."""
        if any(each.vehicle == vehicle for each in self._flown):
            raise ValueError(f"vehicle '{vehicle}': an autopilot flies it already")

    def join(self, partner: Partner) -> None:
        """Let no step be made without a frame of this partner."""
        names = list(self._sim.vehicles)
        self._flown = sorted([*self._flown, partner], key=lambda each: names.index(each.vehicle))
        self._sim.lockstep.attach(self)

    def leave(self, partner: Partner) -> None:
        """Make steps without this partner; without any, return control to the simulator."""
        self._flown.remove(partner)
        if not self._flown:
            self._sim.lockstep.detach()

    def advance(self, steps: int) -> None:
        """Make one step for a frame of each. In a live simulator, this ends early if a firmware is silent."""
        while steps:
            made = self._run(steps)
            steps -= made
            if not made:
                for each in self._flown:
                    each.note_missing()
                if self._flown[0].is_live:
                    return

    def _run(self, steps: int) -> int:
        """Return the number of steps made."""
        flown, tick = self._flown, self._sim.tick
        for each in flown:
            each.auxiliary.apply()
        patience_s = min(LIVE_PATIENCE_S, *(each.patience_s for each in flown))
        exchanges, steers = [each.exchange for each in flown], [each.flown.helm.admit_frames() for each in flown]
        frames, changed = _core.run_servo_exchanges(
            exchanges, self._sim._core, min(steps, STEPS_AT_ONCE), patience_s, steers
        )
        for each, sent in zip(flown, frames, strict=True):
            each.take(sent, tick, changed=changed)
        return len(frames[0]) // FRAME_BYTES
