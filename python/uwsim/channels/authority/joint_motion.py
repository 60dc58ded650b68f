"""Trajectories of an arm's joints, as ROS's joint_trajectory_controller takes them, and the motion along one.

Between two points a joint follows the polynomial with the positions, speeds and accelerations that both give: straight,
cubic or quintic. It begins where the joint is. Joints that a trajectory does not name keep their commands.
"""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.channels.source import Source
from uwsim.live import LiveSimulator, NotRunningError, Subscription
from uwsim.simulator.simulator import Simulator

PERIOD_S = 0.02
RESPONSE_S = 0.1  # time constant of what corrects an error, that of a motor's own controller by default
POINTS_MAX = 10_000
LONGEST_S = 1e6
GOAL_TOLERANCE = 0.02  # rad or m, where a goal has none
GOAL_TIME_S = 2.0  # how long after its end, where a goal has none
SUCCESSFUL, PATH_VIOLATED, GOAL_VIOLATED = 0, -4, -5  # control_msgs/action/FollowJointTrajectory
INVALID_GOAL = -1

Now = tuple[int, Floats, Floats, bool]
logger = logging.getLogger("uwsim.channels")


class Point(NamedTuple):
    """The joints at one time, (n,) each."""

    positions: Floats
    speeds: Floats


class Limits(NamedTuple):
    """A joint's lowest and highest position, and its motor's greatest speed."""

    low: float
    high: float
    speed: float


class Trajectory(NamedTuple):
    """Points for joints: times_s (m,) from its start, which is at start_ns or, if that is 0, as soon as it is followed.

    names: of n joints. speeds: (n,), of their motors at most. derivatives: (m, d, n), positions and, as far as given,
    speeds and accelerations.
    """

    names: tuple[str, ...]
    speeds: Floats
    start_ns: int
    times_s: Floats
    derivatives: Floats

    def from_state(self, now: Point, elapsed_s: float) -> Callable[[float], Point]:
        """Return the joints as a function of the time since the start, which begins at the joints' present state."""
        from scipy.interpolate import BPoly

        later = self.times_s > max(elapsed_s, 0.0)
        if not later.any():
            last = Point(self.derivatives[-1, 0], np.zeros(len(self.names)))
            return lambda at_s: last
        times = np.concatenate([[max(elapsed_s, 0.0)], self.times_s[later]])
        first = np.zeros_like(self.derivatives[:1])
        first[0, : min(2, len(first[0]))] = [now.positions, now.speeds][: len(first[0])]
        curve = BPoly.from_derivatives(times, np.concatenate([first, self.derivatives[later]]))
        rate = curve.derivative()

        def at(at_s: float) -> Point:
            inside = float(np.clip(at_s, times[0], times[-1]))
            is_inside = times[0] <= at_s <= times[-1]
            return Point(curve(inside), rate(inside) if is_inside else np.zeros(len(self.names)))

        return at


def trajectory_of(message: Any, source: Source, limits: Mapping[str, Limits]) -> Trajectory:
    """Return a trajectory_msgs/JointTrajectory for the joints with motors. Raises ValueError.

    limits: of these joints by name.
    """
    by_topic = {source.topic(name): name for name in limits}  # as in joint_states
    names = tuple(by_topic.get(name, name) for name in message.joint_names)
    if not names or len(set(names)) != len(names):
        raise ValueError(f"joint_names = {list(names)}: must be one or more different joints")
    for name in names:
        if name not in limits:
            raise ValueError(f"joint_names: {name}: must be one of {', '.join(limits)}")
    if not 1 <= len(message.points) <= POINTS_MAX:
        raise ValueError(f"points: {len(message.points)}: must be 1 to {POINTS_MAX}")
    times = np.array([one.time_from_start.sec + 1e-9 * one.time_from_start.nanosec for one in message.points])
    if times[0] < 0.0 or times[-1] > LONGEST_S or not (np.diff(times) > 0.0).all():
        raise ValueError(f"points: time_from_start: must be positive, increase, and be at most {LONGEST_S:g} s")
    fields = ("positions", "velocities", "accelerations")
    given = [all(len(getattr(one, field)) for one in message.points) for field in fields]
    kept = [field for count, field in enumerate(fields) if all(given[: count + 1])]
    if not kept:
        raise ValueError("points: positions: must be given in each")
    rows = [[_row(one, field, k, len(names)) for field in kept] for k, one in enumerate(message.points)]
    derivatives = np.array(rows, np.float64)
    for column, name in enumerate(names):
        low, high, _ = limits[name]
        beyond = [value for value in derivatives[:, 0, column].tolist() if not low <= value <= high]
        if beyond:
            raise ValueError(f"points: positions: {name} = {beyond[0]:g}: must be in [{low:g}, {high:g}]")
    stamp = message.header.stamp
    speeds = np.array([limits[name].speed for name in names])
    return Trajectory(names, speeds, 1_000_000_000 * stamp.sec + stamp.nanosec, times, derivatives)


def _row(point: Any, field: str, index: int, count: int) -> Floats:
    values = np.asarray(getattr(point, field), np.float64)
    if len(values) != count or not np.isfinite(values).all():
        raise ValueError(
            f"points[{index}].{field} = {values.tolist()}: must be {count} finite numbers, one for each joint"
        )
    return values


class Tolerances(NamedTuple):
    """How far joints may be from the trajectory, (n,) each; infinite: as far as they like. goal_time_s: after its end.

    speeds: at the end.
    """

    path: Floats
    goal: Floats
    speeds: Floats
    goal_time_s: float

    @classmethod
    def usual(cls, count: int) -> Tolerances:
        """Return those of a trajectory that names none."""
        free = np.full(count, np.inf)
        return cls(free, np.full(count, GOAL_TOLERANCE), free, GOAL_TIME_S)


class Outcome(NamedTuple):
    """How a motion ended. code: SUCCESSFUL, or an error of FollowJointTrajectory. why: "" for a success."""

    code: int
    why: str
    is_cancelled: bool = False


class JointMotion:
    """Moves joints along a trajectory by their motors' speeds, commanded every PERIOD_S of simulated time.

    command: issues set_joints with these arguments. fed: called with the elapsed time [s] and the wanted and actual
    points. ended: called once. All run on the simulator's thread, except `end` and what it calls. Another's set_joints
    of these joints ends the motion, and is repeated if one of ours was on its way.
    """

    def __init__(
        self,
        live: LiveSimulator,
        source: Source,
        trajectory: Trajectory,
        command: Callable[..., Any],
        tolerances: Tolerances | None = None,
        fed: Callable[[float, Point, Point], object] = lambda elapsed_s, wanted, actual: None,
        ended: Callable[[Outcome], object] = lambda outcome: None,
    ) -> None:
        self._live, self._source, self._trajectory, self._command = live, source, trajectory, command
        self._tolerances = tolerances or Tolerances.usual(len(trajectory.names))
        self._fed, self._ended = fed, ended
        self._start_ns = trajectory.start_ns
        self._seen_ns = -1
        self._sent: deque[dict[str, dict[str, float]]] = deque()  # commands that have not taken effect
        self._others: dict[str, dict[str, float]] | None = None  # the command that ended the motion
        self._listens = False
        self._curve: Callable[[float], Point] | None = None
        self._loop: Subscription | None = None
        self._outcome: Outcome | None = None

    def start(self) -> None:
        """Begin to move; the motion ends at once if the simulator does not run."""
        try:
            self._loop = self._live.every(PERIOD_S, self._read, self._act)
        except NotRunningError as error:
            self.end(str(error))

    def end(self, why: str, *, is_cancelled: bool = False, code: int = INVALID_GOAL) -> None:
        """End the motion, unless it has ended; the joints stop where they are. May be called on any thread."""
        if self._finish(Outcome(code, why, is_cancelled)):
            self._send(speeds=dict.fromkeys(self._trajectory.names, 0.0))

    def leave(self, why: str) -> None:
        """End the motion because another command follows: the joints keep what they do until then."""
        self._finish(Outcome(INVALID_GOAL, why))

    def _finish(self, outcome: Outcome) -> bool:
        if self._outcome is not None:
            return False
        self._outcome = outcome
        if self._loop is not None:
            self._loop.cancel()
        self._ended(outcome)
        return True

    def commanded(self, name: str, arguments: dict[str, Any]) -> None:
        """End the motion if this is a command of its joints by another; called by the journal."""
        if name == "set_joints" and arguments["vehicle"] == self._source.name:
            given = {what: dict(each) for what, each in arguments.items() if what != "vehicle" and each}
            if given in self._sent:
                while self._sent.popleft() != given:
                    pass
                if self._others is not None:  # ours came after it
                    self._issue(self._others)
            elif any(joint in self._trajectory.names for each in given.values() for joint in each):
                self._others = given
                self.leave("another command moves its joints")
        if self._outcome is not None and not self._sent:
            self._live.simulator.journal.detach(self)

    def _read(self, sim: Simulator) -> Now:
        if not self._listens:
            sim.journal.listen(self, efforts=False)
            self._listens = True
        vehicle = self._source.of(sim)
        assert vehicle.arm is not None
        now = vehicle.arm.read()
        at = [now.names.index(name) for name in self._trajectory.names]
        return sim.time_ns, now.positions[at], now.speeds[at], vehicle.all_stopped

    def _act(self, now: Now) -> None:
        time_ns, positions, speeds, is_stopped = now
        if self._outcome is not None:
            return
        if time_ns < self._seen_ns:
            self.end("the simulator was reset")
            return
        self._seen_ns = time_ns
        if is_stopped:
            self._finish(Outcome(INVALID_GOAL, "all stop is set"))  # it has stopped the motors
            return
        self._start_ns = self._start_ns or time_ns
        elapsed_s = 1e-9 * (time_ns - self._start_ns)
        if elapsed_s < 0.0:
            return
        actual = Point(positions, speeds)
        if self._curve is None:
            self._curve = self._trajectory.from_state(actual, elapsed_s)
        wanted = self._curve(elapsed_s)
        self._fed(elapsed_s, wanted, actual)
        if not self._is_over(elapsed_s, wanted, actual):
            corrected = wanted.speeds + (wanted.positions - positions) / RESPONSE_S
            corrected = np.clip(corrected, -self._trajectory.speeds, self._trajectory.speeds)
            self._send(speeds=dict(zip(self._trajectory.names, corrected.tolist(), strict=True)))

    def _is_over(self, elapsed_s: float, wanted: Point, actual: Point) -> bool:
        errors = np.abs(wanted.positions - actual.positions)
        late_s = elapsed_s - float(self._trajectory.times_s[-1])
        if late_s < 0.0:
            return self._is_beyond(errors, self._tolerances.path, "path", PATH_VIOLATED)
        slow = np.abs(actual.speeds) <= self._tolerances.speeds
        if (errors <= self._tolerances.goal).all() and slow.all():
            names = self._trajectory.names
            self._send(positions=dict(zip(names, self._trajectory.derivatives[-1, 0].tolist(), strict=True)))
            self._finish(Outcome(SUCCESSFUL, ""))
            return True
        if late_s <= self._tolerances.goal_time_s:
            return False
        if not self._is_beyond(errors, self._tolerances.goal, "goal", GOAL_VIOLATED):
            self.end("the joints still move", code=GOAL_VIOLATED)
        return True

    def _is_beyond(self, errors: Floats, allowed: Floats, what: str, code: int) -> bool:
        beyond = np.flatnonzero(errors > allowed)
        if not len(beyond):
            return False
        k = int(beyond[0])
        rule = f"{self._trajectory.names[k]} is {errors[k]:.3g} off, of {allowed[k]:.3g} that the {what} allows"
        self.end(rule, code=code)
        return True

    def _send(self, **values: dict[str, float]) -> None:
        self._sent.append(values)
        self._issue(values)

    def _issue(self, values: dict[str, dict[str, float]]) -> None:
        try:
            self._command(**values)
        except (ValueError, NotRunningError) as error:
            logger.info("joints of '%s': %s", self._source.name, error)
