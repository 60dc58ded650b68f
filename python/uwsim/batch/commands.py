"""The commands of a batch: each commands one vehicle in every member."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.named import did_you_mean
from uwsim.base.sealed import Sealed
from uwsim.batch import arguments
from uwsim.batch.aboard import MemberAboard
from uwsim.batch.programs import Programs
from uwsim.batch.results import BatchMotion
from uwsim.simulator.docking import DockedWarning
from uwsim.simulator.vehicle import Vehicle


class CommandedBatch(Sealed):
    """The part of uwsim.Batch that accepts commands.

    A command stays in effect until the next one. It has no effect in members where all stop or a failsafe overrides it.
    vehicle: by default each member's first. Raises ValueError.
    """

    n: int
    _core: _core.Batch
    _programs: Programs
    _names: list[str]
    _has_warned: bool
    _driven: set[int]  # vehicles that are commanded to move in some members
    _to_check: set[int]  # vehicles that may be docked in some members

    def aboard(self, member: int) -> MemberAboard:
        """Return one member as a Simulator that acts on the member itself and is valid until the member is reset."""
        raise NotImplementedError

    def observe(self, vehicle: str | None = None) -> BatchMotion:
        """Return the true motion of a vehicle (by default the first) in each member."""
        raise NotImplementedError

    def set_effort(self, efforts: ArrayLike, vehicle: str | None = None) -> None:
        """Set efforts (n, 6) in [-1, 1], surge to yaw, like Vehicle.set_effort. Float64 in C order is not copied.

        Raises ValueError for invalid efforts, changing nothing.
        """
        index, values = self._vehicle(vehicle), np.asarray(efforts)
        self._require_efforts(values)
        self._drive(index, values)

    def _require_efforts(self, values: NDArray[np.generic]) -> None:
        if values.shape != (self.n, 6):
            raise ValueError(f"efforts.shape = {values.shape}: expected ({self.n}, 6)")

    def _drive(self, vehicle: int, efforts: NDArray[np.generic]) -> None:
        self._core.set_efforts(vehicle, efforts)
        self._note_driven(vehicle, efforts)
        self._programs.apply(self._names[vehicle], lambda k, rov: rov.set_effort(*efforts[k].tolist()))

    def set_wrench(
        self, force_body_n: ArrayLike, torque_body_nm: ArrayLike = (0.0, 0.0, 0.0), vehicle: str | None = None
    ) -> None:
        """Set the thrusters' total force and torque, (n, 3) or (3,) for all, like Vehicle.set_wrench."""
        index = self._vehicle(vehicle)
        forces = arguments.rows(force_body_n, "force_body_n", self.n, 3)
        torques = arguments.rows(torque_body_nm, "torque_body_nm", self.n, 3)
        for name, values in (("force_body_n", forces), ("torque_body_nm", torques)):
            arguments.require_finite(values, name)
        self._core.set_wrenches(index, np.hstack([forces, torques]))
        self._note_driven(index, forces, torques)
        self._programs.apply(self._names[index], lambda k, rov: rov.set_wrench(forces[k].tolist(), torques[k].tolist()))

    def set_thrusters(self, commands: Mapping[str, ArrayLike], vehicle: str | None = None) -> None:
        """Set thrusters in [-1, 1] by name, (n,) or one value for all, like Vehicle.set_thrusters.

        Thrusters that are not named stop. Raises ValueError. If a name is unknown or a value is not finite, nothing
        changes. If a value is out of range, the other members are still commanded.
        """
        index = self._vehicle(vehicle)
        known = [name for name, _ in self._core.member(0).thruster_commands(index)]
        values = self._by_name(commands, "thrusters", known)
        self._core.set_thrusters(index, list(commands), values)
        self._note_driven(index, values)
        self._programs.apply(self._names[index], lambda k, rov: rov.set_thrusters(_row(commands, values, k)))

    def set_fins(self, angles_rad: Mapping[str, ArrayLike], vehicle: str | None = None) -> None:
        """Set fin deflections [rad] by name, (n,) or one value for all, like Vehicle.set_fins.

        Fins that are not named return to 0. Raises ValueError. If a name is unknown or a value is not finite, nothing
        changes. If a value is out of range, the other members are still commanded.
        """
        index = self._vehicle(vehicle)
        known = [name for name, _ in self._core.member(0).fin_angles_rad(index)]
        values = self._by_name(angles_rad, "fins", known)
        self._core.set_fins(index, list(angles_rad), values)
        self._programs.apply(self._names[index], lambda k, rov: rov.set_fins(_row(angles_rad, values, k)))

    def set_joints(
        self,
        positions: Mapping[str, ArrayLike] | None = None,
        speeds: Mapping[str, ArrayLike] | None = None,
        torques: Mapping[str, ArrayLike] | None = None,
        vehicle: str | None = None,
    ) -> None:
        """Command an arm's joints by name, (n,) or one value for all, like Vehicle.set_joints.

        Raises ValueError. If a value is beyond a joint's limits, the other members are still commanded.
        """
        index = self._vehicle(vehicle)
        known = list(self._core.member(0).arm(index).names)
        given = {
            what: (values or {}, self._by_name(values or {}, what, known))
            for what, values in (("positions", positions), ("speeds", speeds), ("torques", torques))
        }

        def row(k: int) -> dict[str, dict[str, float]]:
            return {what: _row(names, values, k) for what, (names, values) in given.items()}

        def command(others: list[int]) -> None:
            for k in others:
                with named(k):
                    self._core.member(k).command_joints(index, *([*each.items()] for each in row(k).values()))

        self._command(index, range(self.n), command, lambda k, rov: rov.set_joints(**row(k)))

    def drop(self, dropper: str, *, mask: ArrayLike | None = None, vehicle: str | None = None) -> None:
        """Let go of the next body in a dropper, like Dropper.release.

        mask (n,) bool: selects members. Raises ValueError, with the member, for an empty one; the members before it
        have let go.
        """
        name = self._names[self._vehicle(vehicle)]
        for k in arguments.members(mask, self.n):
            with named(k):
                self.aboard(k).vehicles[name].droppers[dropper].release()

    def all_stop(self, on: bool = True, *, mask: ArrayLike | None = None, vehicle: str | None = None) -> None:
        """Stop thrusters and centre fins, overriding all commands until called with False, like Vehicle.all_stop.

        mask (n,) bool: selects members. vehicle: by default all vehicles. Resetting a member also ends its all stop.
        """
        names = self._names if vehicle is None else [self._names[self._vehicle(vehicle)]]
        for k in arguments.members(mask, self.n):
            aboard = self.aboard(k)
            for name in names:
                aboard.vehicles[name].all_stop(on)

    def place(
        self,
        position_world_m: ArrayLike,
        orientation_xyzw: ArrayLike = (0.0, 0.0, 0.0, 1.0),
        velocity_body: ArrayLike = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        *,
        mask: ArrayLike | None = None,
        vehicle: str | None = None,
    ) -> None:
        """Move a vehicle instantly to a pose in each member, like Vehicle.place. A docked vehicle is released.

        position_world_m (n, 3), orientation_xyzw (n, 4), velocity_body (n, 6): one row per member, or a single row for
        all. mask (n,) bool: selects members; the rows of others are ignored. If a pose is not free, raises ValueError
        after the vehicles of the other members have been placed.
        """
        index, members = self._vehicle(vehicle), arguments.members(mask, self.n)
        positions = arguments.rows(position_world_m, "position_world_m", self.n, 3)
        orientations = arguments.rows(orientation_xyzw, "orientation_xyzw", self.n, 4)
        velocities = arguments.rows(velocity_body, "velocity_body", self.n, 6)

        def place(others: list[int]) -> None:
            states = [_core.BodyState(positions[k], orientations[k], velocities[k]) for k in others]
            self._core.set_states(index, others, states)

        self._command(index, members, place, lambda k, rov: rov.place(positions[k], orientations[k], velocities[k]))

    def release(self, mask: ArrayLike | None = None, vehicle: str | None = None) -> None:
        """Release a vehicle from the station in all members, or in those selected by a mask (n,) bool.

        See Vehicle.release.
        """
        index, members = self._vehicle(vehicle), arguments.members(mask, self.n)
        self._command(index, members, partial(self._core.release, index), lambda _, rov: rov.release())

    def _command(
        self,
        vehicle: int,
        members: Sequence[int],
        others: Callable[[list[int]], None],
        own: Callable[[int, Vehicle], object],
    ) -> None:
        """Command all members.

        Each member with a MemberAboard is commanded by own(k, vehicle), so that it takes notice; all others are
        commanded at once.

        Raises the first ValueError after all have been commanded.
        """
        mistakes, chosen = [], set(members)
        vehicles = {k: rov for k, rov in self._programs.vehicles(self._names[vehicle]) if k in chosen}
        try:
            others([k for k in members if k not in vehicles])
        except ValueError as error:
            mistakes.append(error)
        for k, rov in vehicles.items():
            try:
                with named(k):
                    own(k, rov)
            except ValueError as error:
                mistakes.append(error)
        if mistakes:
            raise mistakes[0]

    def _by_name(self, values: Mapping[str, ArrayLike], what: str, known: Sequence[str]) -> Floats:
        """Return values by name as columns, (n, names). Raises ValueError."""
        if not isinstance(values, Mapping):
            raise ValueError(f"{what} is {type(values).__name__}: must be a mapping of names to values")
        columns = np.zeros((self.n, len(values)))
        for column, (name, one) in enumerate(values.items()):
            if name not in known:
                rule = f"must be one of {', '.join(known)}" if known else "there are none"
                raise ValueError(f"{what}[{name!r}]: {rule}{did_you_mean(str(name), list(known))}")
            columns[:, column] = arguments.each(one, f"{what}['{name}']", self.n)
        return columns

    def _vehicle(self, name: str | None) -> int:
        names = self._names
        if name is None:
            return 0
        if name not in names:
            raise ValueError(f"vehicle = {name!r}: must be one of {', '.join(names)}{did_you_mean(str(name), names)}")
        return names.index(name)

    def _note_driven(self, vehicle: int, *values: NDArray[np.generic]) -> None:
        if any(one.any() for one in values):
            self._driven.add(vehicle)
        else:
            self._driven.discard(vehicle)

    def _warn_if_docked(self, vehicle: int) -> None:
        self._has_warned = not self.observe(self._names[vehicle]).released.all()
        self._to_check.discard(vehicle)
        if self._has_warned:
            warnings.warn(
                f"vehicle '{self._names[vehicle]}' is docked in some members: efforts have no effect there before "
                "release() or place()",
                DockedWarning,
                stacklevel=3,
            )


def _row(names: Mapping[str, ArrayLike], values: Floats, k: int) -> dict[str, float]:
    return dict(zip(names, values[k].tolist(), strict=True))


@contextmanager
def named(member: int) -> Iterator[None]:
    """Prefix the message of a ValueError raised in the block with the member's index, as in batch[3]."""
    try:
        yield
    except ValueError as error:
        raise ValueError(f"batch[{member}]: {error}") from None
