"""A vehicle's arm, or the links of an object: their joints' positions, speeds and motors."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.arguments import read_only
from uwsim.base.arrays import Floats
from uwsim.base.quaternions import turned
from uwsim.base.short_repr import ShortRepr
from uwsim.instruments.errors import Errors
from uwsim.scenario.spec.arm import JointErrors, Link
from uwsim.simulator.forces import six_numbers

ByName = Mapping[str, float]

PRESSING = 0.95  # share of a motor's torque from which it is taken to press


@dataclass(frozen=True, eq=False, repr=False)
class ArmReading(ShortRepr):
    """An arm at one time, by joint: hinges in rad, rad/s and N m, slides in m, m/s and N.

    names: of the joints that move, which are their links'. positions, speeds (n,). motor_torques (n,): at the joints,
    at the start of the last step. currents_a (n,): of the motors; NaN where the vehicle's file has no torque per
    ampere.
    """

    names: tuple[str, ...]
    positions: Floats
    speeds: Floats
    motor_torques: Floats
    currents_a: Floats


@dataclass(frozen=True)
class Sensed:
    """The measurements at joints. joints: their errors by name. vehicle: its name. step_s: the time between samples.

    seed: returns the run's.
    """

    joints: Mapping[str, JointErrors]
    vehicle: str
    step_s: float
    seed: Callable[[], int]

    def of(self, joint: str) -> Errors:
        """Return what adds errors to the samples of a joint."""
        return Errors(f"{self.vehicle}/arm/{joint}", 1.0 / self.step_s, self.seed)


def sensed(arm: Mapping[str, Link], vehicle: str, step_s: float, seed: Callable[[], int]) -> Sensed | None:
    """Return what is measured at an arm's joints; None where it has no errors."""
    joints = {name: (link.hinge or link.slide) for name, link in arm.items()}
    errors = {name: joint.errors for name, joint in joints.items() if joint is not None and joint.errors is not None}
    return Sensed(errors, vehicle, step_s, seed) if errors else None


class Arm:
    """A vehicle's arm, `Vehicle.arm`, or the links of an object, `LooseBody.joints`.

    `read` is true, `measure` has errors. names: the joints that move. motors: those with a motor, which accept
    commands.
    """

    def __init__(
        self,
        simulation: _core.Simulation,
        index: int,
        links: list[_core.ArmLink],
        command: Callable[[ByName | None, ByName | None, ByName | None], None],
        sensed: Sensed | None = None,
    ) -> None:
        self._simulation = simulation
        self._index = index
        self._command = command
        self._sensed = sensed
        self._specs = links
        self._moving = [k for k, link in enumerate(links) if link.joint != _core.JointKind.FIXED]
        self.names = tuple(links[k].name for k in self._moving)
        self.motors = tuple(links[k].name for k in self._moving if links[k].strongest > 0)
        self.links = tuple(link.name for link in links)
        self.jaws = jaws(links)
        """The joints of a gripper, and the sign of the speed that closes each; {} without one."""
        self.hand = hand(links, self.jaws)
        """The link that `jog` moves: the one that holds the jaws, or the last; "" if the vehicle does."""
        self.can_jog = len(motors_to(links, self.hand)) > 1
        """True if at least two motors move the hand."""

    def __repr__(self) -> str:
        now = self.read()
        joints = ", ".join(f"{name} {at:.2f}" for name, at in zip(now.names, now.positions, strict=True))
        return f"<Arm: {joints}>"

    def read(self) -> ArmReading:
        """Return the joints' positions, speeds, torques and currents now."""
        now, at = self._simulation.arm(self._index), self._moving
        values = [now.positions, now.speeds, now.motor_torques, now.currents_a]
        return ArmReading(self.names, *(read_only(np.array(each)[at]) for each in values))

    def measure(self) -> ArmReading:
        """Return what encoders and current sensors read now, with the `errors` in the vehicle's file.

        Torques are those that belong to the currents. What has no errors there is read as it is.
        """
        true = self.read()
        if self._sensed is None:
            return true
        positions, speeds, torques, currents = (
            np.array(each) for each in (true.positions, true.speeds, true.motor_torques, true.currents_a)
        )
        stamp_ns = self._simulation.time_ns
        for k, name in enumerate(self.names):
            if (noise := self._sensed.joints.get(name)) is None:
                continue
            errors = self._sensed.of(name)
            for channel, values in (("position", positions), ("speed", speeds), ("current", currents)):
                values[k : k + 1] = errors.added(getattr(noise, channel), channel, values[k : k + 1], stamp_ns)
            if (per_ampere := self._specs[self._moving[k]].torque_per_ampere) > 0.0:
                torques[k] = per_ampere * currents[k]
        return ArmReading(self.names, *(read_only(each) for each in (positions, speeds, torques, currents)))

    def poses_world(self) -> dict[str, Floats]:
        """Return world_from_link of each link, (4, 4), by name."""
        return dict(zip(self.links, self._simulation.links_world(self._index), strict=True))

    def set_joints(
        self, positions: ByName | None = None, speeds: ByName | None = None, torques: ByName | None = None
    ) -> None:
        """Command joints by name; see Vehicle.set_joints."""
        self._command(positions, speeds, torques)

    def reach(
        self,
        point_m: Sequence[float] | Floats,
        direction: Sequence[float] | Floats | None = None,
        *,
        axes: str = "world",
        link: str | None = None,
        tool_m: Sequence[float] | Floats = (0.0, 0.0, 0.0),
        tool_axis: Sequence[float] | Floats = (1.0, 0.0, 0.0),
    ) -> dict[str, float]:
        """Return the joints' positions that bring a link to a point, for `set_joints(positions=...)`.

        point_m: (3,), in the world or, with axes="body", in the vehicle's frame, and then so is `direction`, (3,), that
        the tool's axis is to have; by default any. link: by default the last. tool_m, tool_axis: the tool's point and
        direction in the link's frame. The vehicle is where it is now: one that floats moves while its arm does. Of
        several ways that it finds, the one whose joints turn least. Raises ValueError for what is more than 1 mm or 1
        degree out of reach, saying how near the arm comes.
        """
        from uwsim.simulator.arm_reach import Aim, OutOfReachError, Reach

        name = self.links[-1] if link is None else link
        if name not in self.links:
            raise ValueError(f"link = {name!r}: must be one of {', '.join(self.links)}")
        if axes not in ("world", "body"):
            raise ValueError(f"axes = {axes!r}: must be world or body")
        point, tool = np.array(six_numbers(point_m=(point_m, "m"), tool_m=(tool_m, "m"))).reshape(2, 3)
        if not np.isfinite([point, tool]).all():
            raise ValueError(f"point_m = {point.tolist()} m, tool_m = {tool.tolist()} m: must be finite")
        wanted = None if direction is None else _unit(direction, "direction")
        if axes == "world":
            state = self._simulation.state(self._index)
            inverse = np.asarray(state.orientation_xyzw) * [-1.0, -1.0, -1.0, 1.0]
            point = turned(inverse, point - state.position_world_m)
            wanted = None if wanted is None else turned(inverse, wanted)
        reach = Reach(self._specs, self.links.index(name))
        present = self._simulation.arm(self._index).positions[reach.chain]
        try:
            found = reach.positions(present, Aim(point, wanted, tool, _unit(tool_axis, "tool_axis")))
        except OutOfReachError as error:
            x, y, z = np.asarray(point_m, np.float64).tolist()
            raise ValueError(f"point_m = ({x:.4g}, {y:.4g}, {z:.4g}) m: out of the arm's reach: {error}") from None
        return {self.links[k]: float(at) for k, at in zip(reach.chain, found, strict=True)}

    def jog(self, velocity_m_s: Sequence[float] | Floats) -> dict[str, float]:
        """Return the joints' speeds that move the `hand` with a velocity, for `set_joints(speeds=...)`.

        velocity_m_s: (3,), in the vehicle's frame, relative to the vehicle. The hand goes straight for as long as the
        joints hardly turn: ask again every 0.1 s. Raises ValueError for an arm that is not `can_jog`.
        """
        from uwsim.simulator.arm_reach import Reach

        if not self.can_jog:
            raise ValueError(f"the arm with the links {', '.join(self.links)}: fewer than two motors move its hand")
        velocity = np.array(six_numbers(velocity_m_s=(velocity_m_s, "m/s")))
        if not np.isfinite(velocity).all():
            raise ValueError(f"velocity_m_s = {velocity.tolist()} m/s: must be finite")
        reach = Reach(self._specs, self.links.index(self.hand))
        present = self._simulation.arm(self._index).positions[reach.chain]
        return {self.links[k]: speed for k, speed in reach.speeds(present, velocity).items()}

    @property
    def speed_limits(self) -> dict[str, float]:
        """The fastest speed [rad/s or m/s] of each motor, by joint."""
        return {link.name: link.fastest for link in self._specs if link.name in self.motors}

    def is_pressing(self, joint: str) -> bool:
        """Return whether a joint's motor gives its most: what it moves has met something, or its stop."""
        link = self._specs[self.links.index(joint)]
        torque = float(self._simulation.arm(self._index).motor_torques[self.links.index(joint)])
        return abs(torque) >= PRESSING * link.strongest

    def halt(self) -> None:
        """Stop every motor where it is, without a journal entry: for all stop."""
        if self.motors:
            self._simulation.command_joints(self._index, [], [(name, 0.0) for name in self.motors], [])


def _unit(direction: Sequence[float] | Floats, name: str) -> Floats:
    """Return a direction (3,) with length 1. Raises ValueError."""
    values = np.array(six_numbers(**{name: (direction, "")}))
    length = float(np.linalg.norm(values))
    if not 1e-9 < length < np.inf:
        raise ValueError(f"{name} = {values.tolist()}: must be finite and have a direction")
    return values / length


NUDGE = 1e-3  # rad or m, by which a joint is moved to see what it does

Links = Sequence[_core.ArmLink]


def jaws(links: Links) -> dict[str, float]:
    """Return the joints of an arm's gripper: links with motors side by side on one link, which hold nothing themselves.

    The sign of each is that of the speed that brings its centre of mass nearer to the others'. The first such links
    count; {} if there are none.
    """
    holders = {link.parent for link in links}
    ends = [k for k, link in enumerate(links) if k not in holders and link.strongest > 0.0]
    for first in ends:
        beside = [k for k in ends if links[k].parent == links[first].parent]
        if len(beside) > 1:
            return {links[k].name: _closing(links, k, [other for other in beside if other != k]) for k in beside}
    return {}


def hand(links: Links, jaws: Mapping[str, float]) -> str:
    """Return the name of the link that holds the jaws, or of the last one; "" if the vehicle holds the jaws."""
    if not jaws:
        return links[-1].name
    parent = next(link.parent for link in links if link.name in jaws)
    return "" if parent is None else links[parent].name


def motors_to(links: Links, name: str) -> list[str]:
    """Return the joints with motors from a link to the vehicle."""
    found = []
    at = next((k for k, link in enumerate(links) if link.name == name), None)
    while at is not None:
        if links[at].strongest > 0.0:
            found.append(links[at].name)
        at = links[at].parent
    return found


def _closing(links: Links, own: int, others: Sequence[int]) -> float:
    """Return the sign of a joint's speed that brings its link nearer to others, from where all are at first."""
    still, water = _core.Mechanism(list(links)), _core.Water()

    def middle(k: int) -> NDArray[np.float64]:
        pose = still.world_from_link(k, water)
        return np.asarray(pose[:3, :3] @ links[k].centre_of_mass_m + pose[:3, 3])

    def distance_m() -> float:
        return float(np.linalg.norm(np.mean([middle(k) for k in others], axis=0) - middle(own)))

    for k, link in enumerate(links):
        if link.joint != _core.JointKind.FIXED:
            still.place(k, link.start)
    before_m = distance_m()
    still.place(own, links[own].start + NUDGE)
    return 1.0 if distance_m() <= before_m else -1.0
