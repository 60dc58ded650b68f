"""The commands of a simulated vehicle: their effects on the simulation and their journal entries."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from uwsim import _core
from uwsim.base.arguments import number, numbers_by_name
from uwsim.base.arrays import Floats
from uwsim.base.axes import AXES
from uwsim.base.commands import Placeable, command_named
from uwsim.base.journal import EFFORT, Journal
from uwsim.base.sealed import Attached
from uwsim.simulator.arm import Arm, ByName
from uwsim.simulator.docking import Dock
from uwsim.simulator.forces import push, six_numbers
from uwsim.simulator.helm import Helm, Reason, Source
from uwsim.simulator.tether import Tether

PLAIN = {float}


class CommandedVehicle(Attached, Placeable):
    """The part of uwsim.simulator.vehicle.Vehicle that accepts commands.

    A command stays in effect until the next one; a command that raises ValueError changes nothing. helm: decides
    whether commands take effect.
    """

    name: str
    helm: Helm
    tether: Tether | None
    arm: Arm | None
    _simulation: _core.Simulation
    _index: int
    _dock: Dock
    _journal: Journal
    _idle_axes: tuple[int, ...]
    """Indices of the axes that nothing drives."""

    @property
    def released(self) -> bool:
        """Whether the vehicle has left the station."""
        return self._simulation.released(self._index)

    @property
    def all_stopped(self) -> bool:
        """Whether all stop is set."""
        return self.helm.all_stopped

    def command(self, name: str, /, **arguments: Any) -> Any:
        """Issue a command of uwsim.base.commands by name. Raises ValueError, changing nothing."""
        command = command_named(name)
        return command.give(self, self._journal, command.named(self.name, arguments))

    def set_effort(
        self,
        surge: float = 0.0,
        sway: float = 0.0,
        heave: float = 0.0,
        roll: float = 0.0,
        pitch: float = 0.0,
        yaw: float = 0.0,
    ) -> None:
        """Command efforts in [-1, 1] along and about the body axes (REP 103: forward, left, up) until the next command.

        Full effort on one axis alone is the largest wrench that the vehicle can produce on it, or the largest
        deflection of its fins; efforts that together exceed the thrusters' limits are scaled down together. Efforts on
        axes that are not `controllable` have no effect, with one IdleAxisWarning for each. Raises ValueError for an
        effort outside [-1, 1] or not finite.
        """
        efforts: tuple[float, ...] = (surge, sway, heave, roll, pitch, yaw)
        if set(map(type, efforts)) != PLAIN:
            efforts = tuple(number(value, f"effort.{axis}") for axis, value in zip(AXES, efforts, strict=True))
        moves = any(efforts)
        self.helm.admit(EFFORT, moves=moves)
        self._simulation.set_effort(self._index, *efforts)
        if self._idle_axes:
            self._warn_of_idle(efforts)
        self.helm.settle(moves=moves, stick=efforts)
        if self._journal.of_efforts:
            self._note(EFFORT, **dict(zip(AXES, efforts, strict=True)))

    def _warn_of_idle(self, efforts: Sequence[float]) -> None:
        commanded = [AXES[k] for k in self._idle_axes if efforts[k]]
        if commanded:
            self.helm.warn_of_idle(commanded, [axis for k, axis in enumerate(AXES) if k not in self._idle_axes])

    def set_wrench(
        self, force_body_n: Sequence[float] | Floats, torque_body_nm: Sequence[float] | Floats = (0.0, 0.0, 0.0)
    ) -> None:
        """Command the total thruster force (3,) and torque (3,) about the origin, in body axes and for still water.

        Fins are not affected. A wrench beyond the thrusters' limits is scaled down, keeping its direction. Raises
        ValueError for wrong shapes and for values that are not finite.
        """
        parts = six_numbers(force_body_n=(force_body_n, "N"), torque_body_nm=(torque_body_nm, "N m"))
        self.helm.admit("set_wrench", moves=any(parts))
        self._simulation.set_wrench(self._index, np.array(parts))
        self.helm.settle(moves=any(parts))
        self._note("set_wrench", force_body_n=parts[:3], torque_body_nm=parts[3:])

    def set_thrusters(self, commands: Mapping[str, float]) -> None:
        """Command thrusters in [-1, 1] by name; those not named stop. Fins are not affected. Raises ValueError."""
        known = [name for name, _ in self._simulation.thruster_commands(self._index)]
        pairs = numbers_by_name(commands, "thrusters", known)
        moves = any(value for _, value in pairs)
        self.helm.admit("set_thrusters", moves=moves)
        self._simulation.set_thrusters(self._index, pairs)
        self.helm.settle(moves=moves)
        self._note("set_thrusters", commands=dict(pairs))

    def set_fins(self, angles_rad: Mapping[str, float]) -> None:
        """Command fin deflections by name, right-handed about each fin's span; fins not named return to 0.

        Thrusters are not affected. Raises ValueError.
        """
        known = [name for name, _ in self._simulation.fin_angles_rad(self._index)]
        pairs = numbers_by_name(angles_rad, "fins", known, "rad")
        moves = any(value for _, value in pairs)
        self.helm.admit("set_fins", moves=moves)
        self._simulation.set_fins(self._index, pairs)
        self.helm.settle(moves=moves or self.helm.is_driven)
        self._note("set_fins", angles_rad=dict(pairs))

    def steer_silently(self, efforts: Sequence[float]) -> None:
        """Set efforts, clipped to [-1, 1], without a journal entry: they follow from journalled events."""
        if not self.all_stopped:
            self._simulation.set_effort(self._index, *[min(max(effort, -1.0), 1.0) for effort in efforts])

    def override_failsafe(self) -> None:
        """Take back control from the failsafe, which then ignores this cause. Raises ValueError without a failsafe."""
        self.helm.override()
        self._note("override_failsafe")

    def all_stop(self, on: bool = True) -> None:
        """Stop the thrusters and centre the fins, overriding all commands until called with False.

        Until then commands have no effect, with a single AllStopWarning, and a docked vehicle stays in the dock.
        Afterwards the vehicle is idle until the next command; a failsafe that is steering continues from there. Raises
        ValueError.
        """
        self.helm.all_stop(on)
        self._note("all_stop", on=bool(on))

    def release(self) -> None:
        """Leave the station; the mission time starts.

        Does nothing if the vehicle has already left. Raises ValueError if all stop prevents it.
        """
        if not self.released:
            self.helm.require("release", Source.FAILSAFE)
        self._simulation.release(self._index)
        self._note("release")

    def undock(self) -> None:
        """Leave the station: release the vehicle and place it, at rest, at the dock's exit (station.exit_m).

        The vehicle keeps the dock's heading and its commands. Raises ValueError, changing nothing, if the vehicle is
        not docked, the exit is not clear, or all stop is set.
        """
        if self.released:
            raise ValueError(f"vehicle '{self.name}': undock: is not docked")
        self.helm.require("undock", Source.FAILSAFE)
        with self._named_errors():
            self._dock.require_exit(self._index)
        self._put(_core.BodyState(self._dock.exit_world_m, self._dock.orientation_xyzw, np.zeros(6)))
        self._note("undock")

    def dock(self) -> None:
        """Enter the station's dock from nearby; the dock holds the vehicle, at rest, until the next release or undock.

        The vehicle must be within 1.5 m of its docked position, slower than 0.5 m/s and within 30 degrees of the dock's
        heading, and the dock must be empty; otherwise a ValueError states by how much a limit is exceeded. Docking ends
        the vehicle's commands and charges its battery immediately: the next release starts another mission.
        """
        if not self.released:
            raise ValueError(f"vehicle '{self.name}': dock: is docked already")
        with self._named_errors():
            self._dock.require_entry(self._index)
        self.helm.end_holds(Reason.DOCKED)
        self._simulation.dock(self._index, self._dock.position_world_m, self._dock.orientation_xyzw)
        self.helm.is_driven = False
        self._note("dock")

    def place(
        self,
        position_world_m: Sequence[float] | Floats,
        orientation_xyzw: Sequence[float] | Floats = (0.0, 0.0, 0.0, 1.0),
        velocity_body: Sequence[float] | Floats = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    ) -> None:
        """Place the vehicle at a pose, at rest unless velocity_body (6,) is set; a docked vehicle is released.

        Commands remain in effect, propellers keep turning, and sensors keep their samples. Raises ValueError for values
        that are not finite or too large, and if the vehicle's origin is not above the ground, or is inside a closed
        obstacle. The hull is not checked: if it overlaps a surface, contact forces push it out.
        """
        self._put(_core.BodyState(position_world_m, orientation_xyzw, velocity_body))
        self._note(
            "place", position_world_m=position_world_m, orientation_xyzw=orientation_xyzw, velocity_body=velocity_body
        )

    def set_winch(self, rate_m_s: float | None = None, tension_n: float | None = None) -> None:
        """Command the winch of the vehicle's tether: pay out at a rate, keep a tension, or, without either, hold.

        It stops at its shortest and its greatest length. rate_m_s: negative to recover, which the tension slows: at the
        winch's `strongest_n` it recovers nothing. Raises ValueError, changing nothing.
        """
        self._note("set_winch", **self._own_tether.wind(rate_m_s, tension_n))

    def cut_tether(self, at_m: float) -> None:
        """Cut the vehicle's tether at this length from its anchor. Raises ValueError, changing nothing."""
        self._note("cut_tether", **self._own_tether.cut(at_m))

    @property
    def _own_tether(self) -> Tether:
        if self.tether is None:
            raise ValueError(f"vehicle '{self.name}': has no tether")
        return self.tether

    def set_joints(
        self, positions: ByName | None = None, speeds: ByName | None = None, torques: ByName | None = None
    ) -> None:
        """Command the joints of the vehicle's arm by name, until the next command; the others keep theirs.

        positions: to which the motor's controller turns [rad or m]. speeds: that it keeps [rad/s or m/s]. torques: of
        the motor at the joint [N m or N]. It does as much as its torque and its stops allow. At first, and in the dock,
        motors hold their positions. Raises ValueError, changing nothing, for a joint without a motor, a value beyond
        its limits, and while all stop is set.
        """
        if self.arm is None:
            raise ValueError(f"vehicle '{self.name}': has no arm")
        if self.all_stopped:
            raise ValueError(f"vehicle '{self.name}': set_joints: all stop is set")
        units = {"positions": "rad or m", "speeds": "rad/s or m/s", "torques": "N m or N"}
        given = {"positions": positions, "speeds": speeds, "torques": torques}
        pairs = {
            what: numbers_by_name(values or {}, what, list(self.arm.motors), units[what])
            for what, values in given.items()
        }
        named = [name for each in pairs.values() for name, _ in each]
        if twice := [name for name in named if named.count(name) > 1]:
            raise ValueError(f"joint {twice[0]!r}: must have one of a position, a speed and a torque")
        self._simulation.command_joints(self._index, *pairs.values())
        self._note("set_joints", **{what: dict(each) or None for what, each in pairs.items()})

    def apply_wrench(
        self,
        force_n: Sequence[float] | Floats,
        torque_nm: Sequence[float] | Floats = (0.0, 0.0, 0.0),
        axes: str = "body",
        duration_s: float | None = None,
    ) -> None:
        """Push the vehicle from outside with a force (3,) [N] and a torque (3,) [N m] at its origin.

        It acts from the next step on, besides thrusters, water and the scenario's `wrenches`, for `duration_s`, rounded
        to steps, or until the next call; (0, 0, 0) ends it. axes: "body", which turn with the vehicle, or "world". The
        dock holds a docked vehicle against it. Raises ValueError, changing nothing.
        """
        pushed = push(force_n, torque_nm, axes, duration_s)
        self._simulation.apply_wrench(self._index, pushed.wrench, pushed.in_world_axes, pushed.duration_s)
        self._note("apply_wrench", **pushed.noted)

    def _put(self, state: _core.BodyState) -> None:
        self._simulation.set_state(self._index, state)
        self.helm.end_holds(Reason.PLACED)

    @contextmanager
    def _named_errors(self) -> Iterator[None]:
        try:
            yield
        except ValueError as error:
            raise ValueError(f"vehicle '{self.name}': {error}") from None

    def _note(self, command: str, **arguments: Any) -> None:
        """Notify the simulator's observers of a command that has taken effect."""
        if self._journal.observers:
            self._journal.note(command, vehicle=self.name, **arguments)

    def warn_if_docked(self) -> None:
        """Warn, once, if the vehicle is being commanded while docked. Called by Simulator.step."""
        if self.helm.is_driven and not self.released:
            self.helm.warn_of_dock()
