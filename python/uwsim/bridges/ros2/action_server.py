"""ActionServer: the three services and two topics that implement an action in ROS 2.

See https://design.ros2.org/articles/actions.html, and rcl_action for the return values of the calls.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial
from typing import Any, Protocol

import numpy as np

from uwsim.bridges.actions import ACCEPTED, CANCELING, EXECUTING, SUCCEEDED, Goal, JointGoal, Offered, accepted
from uwsim.bridges.ros2.transport import Call
from uwsim.channels.ros import build
from uwsim.channels.ros.cdr import Distro, encode
from uwsim.channels.ros.messages import from_bytes
from uwsim.channels.ros.service_types import request_type, response_type
from uwsim.live import LiveSimulator

STATUS, CANCEL = "action_msgs/msg/GoalStatusArray", "action_msgs/srv/CancelGoal"
FEEDBACK_DEPTH, STATUS_DEPTH = 10, 1  # as in rclcpp_action and rcl_action_qos_profile_status_default
NONE, REJECTED, UNKNOWN_GOAL, TERMINATED = range(4)  # action_msgs/srv/CancelGoal
UNKNOWN_STATUS = 0
KEPT_MAX = 100  # number of ended goals whose results can still be requested
NO_IDENTITY = bytes(16)


class Publisher(Protocol):
    """Returns a function that publishes messages on a new topic."""

    def __call__(self, topic: str, type_name: str, depth: int, *, latched: bool) -> Callable[[Any], None]:
        """Create the topic."""


class _Kept:
    """A goal. result: set when the goal has ended. waiting: calls that are waiting for the result."""

    def __init__(self, identity: bytes, accepted_ns: int) -> None:
        self.identity, self.accepted_ns = identity, accepted_ns
        self.goal: Goal | JointGoal | None = None
        self.status = ACCEPTED
        self.result: Any = None
        self.waiting: list[Call] = []

    @property
    def has_ended(self) -> bool:
        """True once the goal has a final status."""
        return self.status >= SUCCEEDED

    def info(self) -> Any:
        """Return the goal's identifier and the time at which it was accepted."""
        identity = build.message("unique_identifier_msgs/msg/UUID", uuid=np.frombuffer(self.identity, np.uint8))
        return build.message("action_msgs/msg/GoalInfo", goal_id=identity, stamp=build.time(self.accepted_ns))


class ActionServer:
    """Serves an action to ROS 2. publisher, offer: create topics and services. report: why a goal was rejected."""

    def __init__(
        self,
        live: LiveSimulator,
        action: Offered,
        distro: Distro,
        publisher: Publisher,
        offer: Callable[[str, str, Callable[[Call], None]], None],
        report: Callable[[str], object],
    ) -> None:
        self._live, self._action, self._distro, self._report = live, action, distro, report
        self._lock = threading.RLock()
        self._goals: dict[bytes, _Kept] = {}
        own, kind = f"{action.name}/_action", action.type
        self._feed_back = publisher(f"{own}/feedback", f"{kind}_FeedbackMessage", FEEDBACK_DEPTH, latched=False)
        self._publish_status = publisher(f"{own}/status", STATUS, STATUS_DEPTH, latched=True)
        offer(f"{own}/send_goal", f"{kind}_SendGoal", self._send_goal)
        offer(f"{own}/cancel_goal", CANCEL, self._cancel_goal)
        offer(f"{own}/get_result", f"{kind}_GetResult", self._get_result)

    def close(self) -> None:
        """Abort the goals in progress."""
        with self._lock:
            goals = [kept.goal for kept in self._goals.values() if kept.goal is not None and not kept.has_ended]
        for goal in goals:
            goal.close()

    def _send_goal(self, call: Call) -> None:
        kind = f"{self._action.type}_SendGoal"
        request = from_bytes(call.request, request_type(kind))
        kept = _Kept(bytes(request.goal_id.uuid), self._live.time_ns)
        try:
            with self._lock:
                if kept.identity in self._goals:
                    raise ValueError("its identifier has been used before")
                fed, ended = partial(self._fed, kept), partial(self._ended, kept)
                kept.goal = accepted(self._live, self._action, request.goal, fed, ended)
                self._goals[kept.identity] = kept
        except (ValueError, RuntimeError) as error:
            self._report(f"/{self._action.name}: goal rejected: {error}")
            kept.goal = None
        stamp = build.time(kept.accepted_ns)
        self._answer(call, build.message(response_type(kind), accepted=kept.goal is not None, stamp=stamp))
        if kept.goal is not None:
            self._enter(kept, ACCEPTED)
            self._enter(kept, EXECUTING)
            kept.goal.start()

    def _cancel_goal(self, call: Call) -> None:
        """Cancel the goal with an ID, all goals accepted up to a time, both, or all goals, depending on the request."""
        wanted = from_bytes(call.request, request_type(CANCEL)).goal_info
        identity, until_ns = bytes(wanted.goal_id.uuid), 1_000_000_000 * wanted.stamp.sec + wanted.stamp.nanosec
        all_of_them = identity == NO_IDENTITY and until_ns == 0
        with self._lock:
            known = self._goals.get(identity)
            chosen = [
                kept for kept in self._goals.values()
                if not kept.has_ended
                and (all_of_them or kept.identity == identity or (until_ns and kept.accepted_ns <= until_ns))
            ]  # fmt: skip
            for kept in chosen:
                self._enter(kept, CANCELING)
        code = NONE
        if not chosen and until_ns == 0 and identity != NO_IDENTITY:
            code = UNKNOWN_GOAL if known is None else TERMINATED
        infos = [kept.info() for kept in chosen]
        self._answer(call, build.message(response_type(CANCEL), return_code=code, goals_canceling=infos))
        for kept in chosen:
            if kept.goal is not None:
                kept.goal.cancel()

    def _get_result(self, call: Call) -> None:
        """Answer with the goal's result as soon as it has ended."""
        request = from_bytes(call.request, request_type(f"{self._action.type}_GetResult"))
        with self._lock:
            kept = self._goals.get(bytes(request.goal_id.uuid))
            if kept is not None and not kept.has_ended:
                kept.waiting.append(call)
                return
        self._give_result(call, kept)

    def _fed(self, kept: _Kept, feedback: Any) -> None:
        identity = kept.info().goal_id
        self._feed_back(build.message(f"{self._action.type}_FeedbackMessage", goal_id=identity, feedback=feedback))

    def _ended(self, kept: _Kept, status: int, result: Any) -> None:
        with self._lock:
            kept.result = result
            waiting, kept.waiting = kept.waiting, []
            self._enter(kept, status)
            ended = [one.identity for one in self._goals.values() if one.has_ended]
            for identity in ended[:-KEPT_MAX]:
                del self._goals[identity]
        for call in waiting:
            self._give_result(call, kept)

    def _give_result(self, call: Call, kept: _Kept | None) -> None:
        name = response_type(f"{self._action.type}_GetResult")
        if kept is None:
            self._answer(call, build.message(name, status=UNKNOWN_STATUS))
        else:
            self._answer(call, build.message(name, status=kept.status, result=kept.result))

    def _enter(self, kept: _Kept, status: int) -> None:
        """Change a goal's status, and publish the statuses of all goals."""
        with self._lock:
            kept.status = status
            found = [
                build.message("action_msgs/msg/GoalStatus", goal_info=one.info(), status=one.status)
                for one in self._goals.values()
            ]
            self._publish_status(build.message(STATUS, status_list=found))

    def _answer(self, call: Call, response: Any) -> None:
        call.reply(encode(response, self._distro))
