"""Batch: many independent simulations of one world."""

from __future__ import annotations

import json
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwsim import _core
from uwsim.base.arguments import checked_threads
from uwsim.base.did_you_mean import did_you_mean
from uwsim.base.sealed import Sealed
from uwsim.batch import arguments
from uwsim.batch.aboard import MemberAboard
from uwsim.batch.arguments import Changes, FaultList, whole
from uwsim.batch.members import Member, Members
from uwsim.batch.programs import Programs
from uwsim.batch.results import (
    BatchMotion,
    BatchPings,
    BatchSamples,
    Buffers,
    motion_buffers,
    ping_buffers,
    sample_buffers,
)
from uwsim.scenario import Scenario, build_world, load
from uwsim.scenario.fingerprint import build_fingerprint, scenario_fingerprint
from uwsim.scenario.spec.fault import FaultModel
from uwsim.simulator.docking import DockedWarning
from uwsim.simulator.simulator import Simulator

MEMBERS_MAX = 1_000_000


class Batch(Sealed):
    """n independent simulations of one scenario.

    Member k is bit-identical to Simulator(scenario, seed=seeds[k]) with parameters[k] set, for any number of threads.
    The members share the terrain, the obstacles and the acceleration structures for rays and contacts.

    scenario: the name of a packaged scenario, the path of a YAML file, or a Scenario. seeds: n whole numbers; defaults
    to the scenario's seed and the numbers that follow it. parameters: values keyed by the names in
    Simulator.parameters, as one mapping per member or a single mapping for all. faults: n lists, or one list for all,
    that replace the scenario's faults and have the same keys. threads: number of threads; defaults to one per core.

    Calls release the GIL and use all threads. `observe`, `read` and `ping` return arrays that belong to the batch: the
    next such call overwrites them, so copy what you keep. Only one thread at a time may use a batch. Raises ValueError;
    the message for an error in one member begins with its index, such as batch[3].
    """

    scenario: Scenario
    n: int
    threads: int
    _fixed_when = "the batch is made"
    _changed_by = MappingProxyType(
        {"seeds": "reset(seeds=...)", "parameters": "reset(parameters=...)", "faults": "reset(faults=...)"}
    )

    def __init__(
        self,
        scenario: str | Path | Scenario = "lake",
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
        self._motion = [motion_buffers(self.n) for _ in self._names]
        self._samples: dict[tuple[int, int], Buffers[BatchSamples]] = {}
        self._pings: dict[tuple[int, int, bool], Buffers[BatchPings]] = {}
        self._has_warned = False

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
        """Set efforts, if given, and advance every member by n fixed steps; efforts are held until replaced.

        efforts: (n, 6) in [-1, 1], surge to yaw, for each member's first vehicle, or a dict of such arrays by vehicle;
        float64 in C order is not copied. Raises ValueError for invalid efforts before taking any step. Also raises
        ValueError if a member's motion diverges, after all others have been stepped; that member stays where it was and
        must be reset.
        """
        steps = whole(n, "n", 0, 2**63 - 1)
        if efforts is not None:
            by_name = efforts if isinstance(efforts, Mapping) else {self._names[0]: efforts}
            checked = {self._vehicle(name): np.asarray(values) for name, values in by_name.items()}
            for values in checked.values():
                if values.shape != (self.n, 6):
                    raise ValueError(f"efforts.shape = {values.shape}: expected ({self.n}, 6)")
            for vehicle, values in checked.items():
                self._core.set_efforts(vehicle, values)
                self._programs.hear_efforts(self._names[vehicle], values)
                if steps and not self._has_warned and values.any():
                    self._warn_if_docked(vehicle)
        self._programs.step(steps)

    def observe(self, vehicle: str | None = None) -> BatchMotion:
        """Return the true motion of a vehicle (by default the first) in each member."""
        index = self._vehicle(vehicle)
        motion = self._motion[index]
        self._core.motion(index, *motion.writable)
        return motion.shown

    def read(self, sensor: str, vehicle: str | None = None, *, noise: bool = True) -> BatchSamples:
        """Return the latest sample from a sensor in each member, like Sensor.read."""
        index = self._vehicle(vehicle)
        sensors = self._members.vehicles[index].sensors
        names = [spec.name for spec in sensors]
        if sensor not in names:
            rule = f"must be one of {', '.join(names)}{did_you_mean(str(sensor), names)}"
            raise ValueError(f"{self._names[index]}.sensors[{sensor!r}]: {rule}")
        key = index, names.index(sensor)
        if key not in self._samples:
            self._samples[key] = sample_buffers(self.n, _core.sensor_kind(sensors[key[1]].kind).fields)
        samples = self._samples[key]
        self._core.read_sensor(*key, noise, *samples.writable)
        self._programs.tell(*key, noise, samples)
        return samples.shown

    def ping(self, vehicle: str | None = None) -> BatchPings:
        """Ping with a vehicle's first sonar in each member; in physics mode, BatchPhysicsPings are returned.

        The sonars of all members must have the same number of beams and the same mode. Raises ValueError.
        """
        index = self._vehicle(vehicle)
        if not self._members.vehicles[index].sonars:
            raise ValueError(f"vehicle '{self._names[index]}': carries no sonar")
        modes = self._core.in_physics_mode(index, 0)
        in_physics_mode = modes[0]
        if in_physics_mode in modes and (not in_physics_mode) in modes:
            other = f"another in batch[{modes.index(not in_physics_mode)}] than in batch[0]"
            raise ValueError(f"{self._names[index]}.sonar.mode: {other}: a batch pings in one mode")
        key = index, self._core.beams(index, 0), in_physics_mode
        if key not in self._pings:
            self._pings[key] = ping_buffers(self.n, key[1], in_physics_mode)
        pings = self._pings[key]
        (self._core.acoustic_ping if in_physics_mode else self._core.ping)(index, 0, *pings.writable)
        return pings.shown

    def place(
        self,
        position_world_m: ArrayLike,
        orientation_xyzw: ArrayLike = (0.0, 0.0, 0.0, 1.0),
        velocity_body: ArrayLike = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        *,
        mask: ArrayLike | None = None,
        vehicle: str | None = None,
    ) -> None:
        """Move a vehicle instantly to a pose in each member, like Vehicle.place; a docked vehicle is released.

        position_world_m (n, 3), orientation_xyzw (n, 4), velocity_body (n, 6): one row per member, or a single row for
        all. mask (n,) bool: selects members; the others' rows are ignored. Raises ValueError if a pose is not free,
        after the vehicles of the other members have been placed.
        """
        members = arguments.members(mask, self.n)
        positions = arguments.rows(position_world_m, "position_world_m", self.n, 3)
        orientations = arguments.rows(orientation_xyzw, "orientation_xyzw", self.n, 4)
        velocities = arguments.rows(velocity_body, "velocity_body", self.n, 6)
        states = [_core.BodyState(positions[k], orientations[k], velocities[k]) for k in members]
        self._core.set_states(self._vehicle(vehicle), members, states)

    def release(self, mask: ArrayLike | None = None, vehicle: str | None = None) -> None:
        """Release a vehicle from the station in all members, or in those selected by a mask (n,) bool.

        See Vehicle.release.
        """
        self._core.release(self._vehicle(vehicle), arguments.members(mask, self.n))

    def reset(
        self,
        mask: ArrayLike | None = None,
        *,
        seeds: Sequence[int] | NDArray[np.integer[Any]] | None = None,
        parameters: Changes | Sequence[Changes] | None = None,
        faults: FaultList | Sequence[FaultList] | None = None,
    ) -> None:
        """Restart all members, or those selected by a mask (n,) bool, in their initial state.

        seeds, parameters, faults: replace the previous ones from now on; as in the constructor, but only the values for
        the selected members are used. Raises ValueError without changing anything.
        """
        chosen = arguments.members(mask, self.n)
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
        """Return a member's onboard programs (faults, failsafes and events), valid until the member is reset.

        Raises ValueError.
        """
        k = whole(member, "member", 0, self.n - 1)
        return self._programs.aboard(k, lambda: self._member(k))

    def _member(self, k: int) -> Member:
        return self._members.member(k, self._seeds[k], self._changes[k], self._faults[k])

    def simulator(self, member: int) -> Simulator:
        """Return a Simulator in a member's current state, independent of the batch, for closer inspection."""
        k = whole(member, "member", 0, self.n - 1)
        scenario = self.scenario.with_changes(seed=self._seeds[k])
        if self._faults[k] != scenario.faults:
            scenario = scenario.model_copy(update={"faults": self._faults[k]})
        sim = Simulator(scenario, threads=self.threads)
        if self._changes[k]:
            sim.parameters.update(self._changes[k])
        origin = scenario_fingerprint(sim.scenario), build_fingerprint()
        notes = json.loads(_core.saved_notes(sim.save_state(), *origin))
        if self._programs.has(k):
            notes |= self.aboard(k).save()
        sim.restore_state(self._core.save_state(k, *origin, json.dumps(notes)))
        return sim

    def _vehicle(self, name: str | None) -> int:
        names = self._names
        if name is None:
            return 0
        if name not in names:
            raise ValueError(f"vehicle = {name!r}: must be one of {', '.join(names)}{did_you_mean(str(name), names)}")
        return names.index(name)

    def _warn_if_docked(self, vehicle: int) -> None:
        motion = self._motion[vehicle]
        self._core.motion(vehicle, *motion.writable)
        if not motion.shown.released.all():
            self._has_warned = True
            warnings.warn(
                f"vehicle '{self._names[vehicle]}' is docked in some members: efforts have no effect there before "
                "release() or place()",
                DockedWarning,
                stacklevel=3,
            )
