"""Goal: a flight on a separate thread, which reports its progress and can be cancelled."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np

from uwsim.base.commands import command_named
from uwsim.bridges.actions.action import Action, Offered, Plan, Progress, Tolerance
from uwsim.bridges.actions.joints import JointAction, JointGoal
from uwsim.channels.authority.steering import require_link
from uwsim.channels.ros import build
from uwsim.live import LiveSimulator
from uwsim.live.vehicle import LiveVehicle
from uwsim.missions import OwnVehicle, StoppedError, drive
from uwsim.missions.moves import can_stand
from uwsim.navigation.control.controller import Controller
from uwsim.navigation.control.protocols import Clock
from uwsim.simulator.helm import Lease, Reason, Source

ACCEPTED, EXECUTING, CANCELING, SUCCEEDED, CANCELED, ABORTED = range(1, 7)  # action_msgs/msg/GoalStatus
FEEDBACK_S = 0.5
CLOSE_S = 2.0
SERVER_STOPS = "the server stops"

Fed = Callable[[Any], object]
Ended = Callable[[int, Any], object]
"""Receives the final status and the result message."""
logger = logging.getLogger("uwsim.actions")


class _EndedError(Exception):
    """Ends a flight early."""

    def __init__(self, status: int, reason: str) -> None:
        super().__init__(reason)
        self.status = status


class Goal:
    """An accepted goal. `start` begins the flight.

    fed: called with each feedback message. ended: called once, at the end. Both are called on the flight's thread.
    Raises ValueError if the goal is impossible or the vehicle cannot be commanded now.
    """

    def __init__(self, live: LiveSimulator, action: Action, goal: Any, fed: Fed, ended: Ended) -> None:
        self.action, self._live, self._fed, self._ended = action, live, fed, ended
        self._name = action.source.name
        action.steering.rights.require(action.name)
        require_link(live, self._name, action.name)
        self._hull: LiveVehicle = live.vehicles[self._name]
        if not self._hull.released:
            raise ValueError(f"vehicle '{self._name}' is at the station: call /{action.source.topic('undock')} first")
        action.steering.helm.require_at_door(action.name, Source.FLIGHT)
        self._plan: Plan = action.route(goal)
        for point in self._plan.points_world_m.tolist():
            if (edge := self._hull.beyond_terrain(*point)) is not None:
                place = ", ".join(f"{part:.1f}" for part in point)
                raise ValueError(f"{action.name}: target ({place}) m: must be above the terrain, {edge}")
        self._stop: _EndedError | None = None
        self._lease: Lease | None = None
        self._vehicle: OwnVehicle | None = None
        self._leg = 0
        self._thread = threading.Thread(target=self._run, name=f"uwsim-{action.name}", daemon=True)

    def start(self) -> None:
        """Begin the flight, which replaces any earlier command from a bridge; it ends at once if others steer."""
        try:
            self._lease = self.action.steering.fly(self.action.name, self._lose)
        except ValueError as error:
            self._end(_EndedError(ABORTED, str(error)))
        self._thread.start()

    def cancel(self) -> None:
        """End the flight within a control period of simulated time, and bring the vehicle to rest."""
        self._end(_EndedError(CANCELED, "cancelled"))

    def leave(self) -> None:
        """End the flight because another command follows. It commands nothing from now on, nor waits for its thread."""
        self._end(_EndedError(ABORTED, Reason.REPLACED))
        if self._lease is not None:
            self._lease.end()

    def close(self) -> None:
        """End the flight because the server is stopping, and wait for its thread."""
        self._end(_EndedError(ABORTED, SERVER_STOPS))
        if self._thread.is_alive() and self._thread is not threading.current_thread():
            self._thread.join(CLOSE_S)

    def _lose(self, reason: Reason) -> None:
        self._end(_EndedError(ABORTED, self.action.steering.helm.refusal(Source.FLIGHT) or reason))

    def _end(self, reason: _EndedError) -> None:
        self._stop = self._stop or reason

    def _run(self) -> None:
        began_s = self._live.simulator.time_s
        status, why = SUCCEEDED, ""
        try:
            with self._live.mission_clock() as clock:
                self._fly(clock, began_s)
        except _EndedError as error:
            status, why = error.status, str(error)
        except (StoppedError, ValueError, RuntimeError) as error:
            status, why = ABORTED, str(error) or type(error).__name__
        except Exception as error:
            logger.exception("action '%s' failed", self.action.name)
            status, why = ABORTED, str(error) or type(error).__name__
        self._rest(status)
        self._ended(status, self.action.result(max(self._live.simulator.time_s - began_s, 0.0), why))

    def _rest(self, status: int) -> None:
        """Keep the vehicle at the target, or else bring it to rest, unless another command steers it by now."""
        if self._lease is None or not self._lease.end() or not self._hull.released:
            return
        flown, points = self._vehicle, self._plan.points_world_m
        with suppress(ValueError, RuntimeError):  # others steer by now, or the simulator does not run
            if status != SUCCEEDED or flown is None or not len(points) or not can_stand(flown):
                self.action.steering.hold_velocity(self._live, np.zeros(6))
                return
            heading_rad = flown.pose.yaw_rad if self._plan.heading_rad is None else self._plan.heading_rad
            assert isinstance(flown.autopilot, Controller)
            self.action.steering.hold_place(
                self._live, points[-1], heading_rad, flown.autopilot.memory, uses_truth=self.action.uses_truth
            )

    def _fly(self, clock: Clock, began_s: float) -> None:
        self.check()
        assert self._lease is not None
        hull = _FlownVehicle(self._live, self.action, self._lease)
        own = None if self.action.uses_truth else hull.start_navigation()
        vehicle = self._vehicle = OwnVehicle(hull, clock, estimate=own)
        holds = hull.holds
        if holds is not None and holds.has_control:
            hull.command("hold")
        settings = self.action.source.now(self._live.simulator)
        tolerance = Tolerance(settings.xy_goal_tolerance, settings.yaw_goal_tolerance)
        drive(self._plan.steps(vehicle, self._begin, tolerance), _WatchedClock(clock, self, vehicle, began_s))

    def _begin(self, leg: int) -> None:
        self._leg = leg

    def check(self) -> None:
        """Raise an exception with the reason if the flight must end now."""
        if self._stop is not None:
            raise self._stop
        if not self._hull.released:
            raise _EndedError(ABORTED, f"vehicle '{self._name}' is at the station")

    def feed_back(self, vehicle: OwnVehicle, elapsed_s: float) -> None:
        """Report the progress."""
        from scipy.spatial.transform import Rotation  # slow to import

        source, pose = self.action.source, vehicle.pose
        quaternion = Rotation.from_matrix(pose.world_from_body[:3, :3]).as_quat()
        legs = np.vstack([pose.position_world_m, self._plan.points_world_m[self._leg :]])
        remaining_m = float(np.linalg.norm(np.diff(legs, axis=0), axis=1).sum())
        stamped = build.message(
            "geometry_msgs/msg/PoseStamped",
            header=build.header(self._live.time_ns, source.frame("odom")),
            pose=build.pose(pose.position_world_m + source.origin_m, quaternion),
        )
        self._fed(self.action.feedback(Progress(stamped, self._leg, remaining_m, elapsed_s)))


def accepted(live: LiveSimulator, action: Offered, goal: Any, fed: Fed, ended: Ended) -> Goal | JointGoal:
    """Return an accepted goal of any action. Raises ValueError; see Goal and JointGoal."""
    if isinstance(action, Action):
        return Goal(live, action, goal, fed, ended)
    assert isinstance(action, JointAction)

    def end(is_reached: bool, is_cancelled: bool, result: Any) -> object:
        return ended(SUCCEEDED if is_reached else CANCELED if is_cancelled else ABORTED, result)

    return JointGoal(live, action, goal, fed, end)


class _FlownVehicle(LiveVehicle):
    """A vehicle that accepts a flight's commands until the flight loses the helm."""

    def __init__(self, live: LiveSimulator, action: Action, lease: Lease) -> None:
        super().__init__(live, action.source.of(live.simulator))
        self._lease = lease

    def command(self, name: str, /, **arguments: Any) -> Any:
        """Issue a command; see LiveVehicle. Raises RuntimeError once the flight has lost the helm."""
        named = command_named(name).named(self.name, arguments)
        return self._lease.give(lambda: self._live.command(name, **named)).result()


class _WatchedClock:
    """A mission clock that reports feedback, and ends the mission when its goal is cancelled or aborted."""

    def __init__(self, clock: Clock, goal: Goal, vehicle: OwnVehicle, began_s: float) -> None:
        self._clock, self._goal, self._vehicle = clock, goal, vehicle
        self._began_s = self._fed_s = began_s

    @property
    def time_s(self) -> float:
        """Simulated time in seconds."""
        return self._clock.time_s

    def wait(self, duration_s: float) -> None:
        """Wait; see LiveClock."""
        self._goal.check()
        self._clock.wait(duration_s)
        self._goal.check()
        if self.time_s >= self._fed_s + FEEDBACK_S:
            self._fed_s = self.time_s
            self._goal.feed_back(self._vehicle, self.time_s - self._began_s)
