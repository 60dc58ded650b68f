"""The programs of batch members. A member with programs is stepped in parts, from one of its events to the next."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence

import numpy as np

from uwsim import _core
from uwsim.batch.aboard import MemberAboard
from uwsim.batch.members import Member, Members
from uwsim.batch.results import BatchSamples, Buffers
from uwsim.scenario.spec.fault import FaultModel
from uwsim.simulator.vehicle import Vehicle


class Programs:
    """Tracks the members that have programs or a MemberAboard. Other members have no overhead.

    Each tracked member has its own agenda (`base/agenda.py`). Between ticks at which its Python items act, it is
    stepped like any other member. Members may temporarily be at different ticks, so that every round of parts keeps all
    threads busy.
    """

    def __init__(self, core: _core.Batch, world: _core.World, scene: _core.RayScene, members: Members, n: int) -> None:
        self._core, self._world, self._scene, self._members, self._n = core, world, scene, members, n
        self._like: MemberAboard | None = None
        self._valid: Sequence[FaultModel] = ()
        self._made: dict[int, Member] = {}
        self._aboard: dict[int, MemberAboard] = {}
        self._off: dict[int, list[tuple[int, int]]] = {}

    def check(self, k: int, member: Member) -> None:
        """Raise ValueError if a member's programs are invalid."""
        if member.has_programs and member.original.faults != self._valid:
            self._new(k, member)

    def begin(self, k: int, member: Member) -> None:
        """Start the programs of a newly created member."""
        self._aboard.pop(k, None)
        self._made.pop(k, None)
        self._off.pop(k, None)
        if off := member.off:
            self._off[k] = off
        if member.has_programs:
            self._made[k] = member
            self._aboard[k] = self._new(k, member)

    def begin_again(self, members: Iterable[int]) -> None:
        """Restart the programs of members that were restarted with the same definition."""
        for k in members:
            self._aboard.pop(k, None)
            if k in self._made:
                self._aboard[k] = self._new(k, self._made[k])

    def has(self, k: int) -> bool:
        """Return whether a member has programs."""
        return k in self._aboard

    def aboard(self, k: int, made: Callable[[], Member]) -> MemberAboard:
        """Return a member's onboard programs, creating them if necessary."""
        if k not in self._aboard:
            self._aboard[k] = self._new(k, made())
        return self._aboard[k]

    def _new(self, k: int, member: Member) -> MemberAboard:
        try:
            made = MemberAboard(
                self._core.member(k), self._world, self._scene, member, self._members.control, self._like
            )
        except ValueError as error:
            raise ValueError(f"batch[{k}]: {error}") from None
        self._like = self._like or made
        self._valid = member.original.faults
        return made

    def vehicles(self, vehicle: str) -> Iterator[tuple[int, Vehicle]]:
        """Yield the index of each member that has a MemberAboard, with one of its vehicles."""
        return ((k, aboard.vehicles[vehicle]) for k, aboard in self._aboard.items())

    def apply(self, vehicle: str, command: Callable[[int, Vehicle], object]) -> None:
        """Call command(k, vehicle) in members where all stop, a failsafe or a hold may affect the command."""
        for k, aboard in self._aboard.items():
            if aboard.vehicles[vehicle].helm.is_watched:
                command(k, aboard.vehicles[vehicle])

    def step(self, steps: int) -> None:
        """Step all members. If a member cannot continue, raises ValueError after the others have been stepped."""
        if not self._aboard:
            self._core.step(steps)
            return
        running = {k: aboard.agenda.parts(steps) for k, aboard in self._aboard.items() if aboard.acts_within(steps)}
        counts = [steps if k not in running else 0 for k in range(self._n)]
        mistakes: list[str] = []
        while True:
            for k in list(running):
                try:
                    counts[k] = next(running[k], 0)
                except ValueError as error:
                    mistakes.append(f"batch[{k}]: {error}")
                if not counts[k]:
                    del running[k]
            if not any(counts):
                break
            try:
                self._core.step_each(counts)
            except ValueError as error:
                mistakes.append(str(error))
            counts = [0] * self._n
        if mistakes:
            raise ValueError(mistakes[0])

    def convert(self, vehicle: int, sensor: int, noise: bool, samples: Buffers[BatchSamples]) -> None:
        """Modify samples in place where a member's sensor is off or has failed."""
        values, _, valid = samples.writable
        for k, off in self._off.items():
            if k not in self._aboard and (vehicle, sensor) in off:
                values[k], valid[k] = np.nan, False
        for k, aboard in self._aboard.items():
            aboard.convert(vehicle, sensor, noise, values[k], valid[k : k + 1])
