"""Batch: many independent simulations of one world."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwsim import _core
from uwsim.base.arguments import checked_threads
from uwsim.batch import arguments
from uwsim.batch.aboard import MemberAboard
from uwsim.batch.arguments import Changes, FaultList, whole
from uwsim.batch.commands import named
from uwsim.batch.instruments import InstrumentedBatch
from uwsim.batch.members import Member, Members
from uwsim.batch.programs import Programs
from uwsim.scenario import AnyScenario, Scenario, build_world, load
from uwsim.scenario.spec.fault import FaultModel
from uwsim.simulator.simulator import Simulator

MEMBERS_MAX = 1_000_000


class Batch(InstrumentedBatch):
    """n independent simulations of one scenario.

    Member k is bit-identical to Simulator(scenario, seed=seeds[k]) with parameters[k] set, for any number of threads.
    The members share the terrain, the obstacles and the acceleration structures for rays and contacts.

    scenario: as for Simulator. seeds: n whole numbers; defaults to the scenario's seed and the numbers that follow it.
    parameters: values keyed by the names in Simulator.parameters, as one mapping per member or a single mapping for
    all. faults: n lists of faults, or one list for all, in the scenario's format, which replace the scenario's faults.
    threads: number of threads; defaults to one per core.

    Calls release the GIL and use all threads. `observe`, `read` and `ping` return arrays that belong to the batch and
    are overwritten by the next such call, so copy those that you keep. Only one thread at a time may use a batch.
    Raises ValueError; the message for an error in one member begins with its index, such as batch[3].
    """

    scenario: Scenario
    threads: int
    _fixed_when = "the batch is made"
    _changed_by = MappingProxyType(
        {"seeds": "reset(seeds=...)", "parameters": "reset(parameters=...)", "faults": "reset(faults=...)"}
    )

    def __init__(
        self,
        scenario: AnyScenario = "lake",
        *,
        n: int,
        seeds: Sequence[int] | NDArray[np.integer[Any]] | None = None,
        parameters: Changes | Sequence[Changes] | None = None,
        faults: FaultList | Sequence[FaultList] | None = None,
        threads: int | None = None,
    ) -> None:
        self.scenario = load(scenario)
        self.n = whole(n, "n", 1, MEMBERS_MAX)
        self.threads = checked_threads(threads)
        self._world = build_world(self.scenario)
        self._fixed_world = _core.FixedWorld(self._world)
        self._names = [entry.name for entry in self.scenario.vehicles]
        self._members = Members(self.scenario, self._world)
        first = self.scenario.seed
        everyone = range(self.n)
        self._seeds = arguments.seeds(range(first, first + self.n) if seeds is None else seeds, self.n, everyone)
        self._changes = arguments.changes({} if parameters is None else parameters, self.n, everyone)
        own: dict[int, tuple[FaultModel, ...]] = dict.fromkeys(everyone, self.scenario.faults)
        self._faults = own if faults is None else arguments.faults(faults, self.n, everyone)
        members = [self._member(k) for k in everyone]
        scene = _core.RayScene(self._world)
        self._core = _core.Batch(self._world, scene, [member.spec for member in members], self.threads)
        self._programs = Programs(self._core, self._world, scene, self._members, self.n)
        for k, member in enumerate(members):
            self._programs.begin(k, member)
        self._has_warned = False
        self._driven: set[int] = set()
        self._to_check = {*range(len(self._names))}
        self._make_buffers()

    def __repr__(self) -> str:
        return f"<Batch of {self.n} '{self.scenario.name}' with {', '.join(self._names)}>"

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seed of each member."""
        return tuple(self._seeds.values())

    @property
    def parameters(self) -> tuple[Changes, ...]:
        """The parameters of each member."""
        return tuple(MappingProxyType(changes) for changes in self._changes.values())

    @property
    def faults(self) -> tuple[tuple[FaultModel, ...], ...]:
        """The initial faults of each member."""
        return tuple(self._faults.values())

    @property
    def world(self) -> _core.FixedWorld:
        """Terrain and obstacles, shared by all members. Its water is the scenario's, not any member's."""
        return self._fixed_world

    def step(self, n: int = 1, efforts: ArrayLike | Mapping[str, ArrayLike] | None = None) -> None:
        """Set efforts, if given, and advance every member by n fixed steps. Efforts are held until replaced.

        efforts: (n, 6) in [-1, 1], surge to yaw, for each member's first vehicle, or a dict of such arrays by vehicle;
        float64 in C order is not copied. Raises ValueError for invalid efforts before taking any step. If a member's
        motion diverges, raises ValueError after all other members have been stepped. The member keeps its last valid
        state and must be reset.
        """
        steps = whole(n, "n", 0, 2**63 - 1)
        if efforts is not None:
            by_name = efforts if isinstance(efforts, Mapping) else {self._names[0]: efforts}
            checked = {self._vehicle(name): np.asarray(values) for name, values in by_name.items()}
            for values in checked.values():
                self._require_efforts(values)
            for vehicle, values in checked.items():
                self._drive(vehicle, values)
        if steps and not self._has_warned:
            for vehicle in self._driven & self._to_check:
                self._warn_if_docked(vehicle)
        self._programs.step(steps)

    def reset(
        self,
        mask: ArrayLike | None = None,
        *,
        seeds: Sequence[int] | NDArray[np.integer[Any]] | None = None,
        parameters: Changes | Sequence[Changes] | None = None,
        faults: FaultList | Sequence[FaultList] | None = None,
    ) -> None:
        """Restart all members, or those selected by a mask (n,) bool, in their initial state.

        seeds, parameters, faults: replace the previous values, as in the constructor, but only those of the selected
        members are used. Raises ValueError without changing anything.
        """
        chosen = arguments.members(mask, self.n)
        self._to_check = {*range(len(self._names))}
        if seeds is None and parameters is None and faults is None:
            self._core.restart(chosen)
            self._programs.begin_again(chosen)
            return
        new_seeds = self._seeds if seeds is None else arguments.seeds(seeds, self.n, chosen)
        new_changes = self._changes if parameters is None else arguments.changes(parameters, self.n, chosen)
        new_faults = self._faults if faults is None else arguments.faults(faults, self.n, chosen)
        members = [self._members.member(k, new_seeds[k], new_changes[k], new_faults[k]) for k in chosen]
        for k, member in zip(chosen, members, strict=True):
            self._programs.check(k, member)
        self._core.restart(chosen, [member.spec for member in members])
        for k, member in zip(chosen, members, strict=True):
            self._seeds[k], self._changes[k], self._faults[k] = new_seeds[k], new_changes[k], new_faults[k]
            self._programs.begin(k, member)

    def aboard(self, member: int) -> MemberAboard:
        """Return one member as a Simulator that acts on the member itself and is valid until the member is reset.

        It gives access to everything that has no batched call: faults, failsafes, events, parameters, holds, lamps, the
        aims of heads and cameras, and the panel. Raises ValueError.
        """
        k = whole(member, "member", 0, self.n - 1)
        return self._programs.aboard(k, lambda: self._member(k))

    def _member(self, k: int) -> Member:
        return self._members.member(k, self._seeds[k], self._changes[k], self._faults[k])

    def save_state(self, member: int) -> bytes:
        """Return a member's state, in the same bytes as Simulator.save_state. Raises ValueError."""
        return self.aboard(member).save_state()

    def restore_state(self, member: int, state: bytes) -> None:
        """Continue a member from a state of a member or a Simulator with the same scenario and seed.

        Raises ValueError, changing nothing, if the state is damaged or has a different scenario or seed.
        """
        aboard = self.aboard(member)
        with named(member):
            aboard.restore_state(state)
        self._to_check = {*range(len(self._names))}

    def simulator(self, member: int) -> Simulator:
        """Return a new Simulator with a copy of a member's current state, independent of the batch."""
        k = whole(member, "member", 0, self.n - 1)
        scenario = self.scenario.with_changes(seed=self._seeds[k])
        if self._faults[k] != scenario.faults:
            scenario = scenario.model_copy(update={"faults": self._faults[k]})
        sim = Simulator(scenario, threads=self.threads)
        sim.restore_state(self.save_state(k))
        return sim
