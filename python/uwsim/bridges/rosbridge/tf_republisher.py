"""Transforms for clients that keep no tf tree, through the interface of tf2_web_republisher.

A client requests frames, a target, a rate and thresholds. It receives changes on a separate topic after a service call
(roslibpy), or as feedback after an action goal (roslibjs). A request ends after a while without subscribers, or when
the goal is cancelled. https://github.com/RobotWebTools/tf2_web_republisher
"""

from __future__ import annotations

import asyncio
import itertools
import math
import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arguments import is_number
from uwsim.base.quaternions import product, turned
from uwsim.bridges.rosbridge.encoding import Sample
from uwsim.bridges.rosbridge.graph import Graph, Reply, Topic
from uwsim.channels.calls.command_services import by_field
from uwsim.channels.ros.message_types import shortened
from uwsim.channels.ros.messages import default_message, to_plain

OWNER = "/tf2_web_republisher"
SERVICE = "republish_tfs"
FIELDS = ("source_frames", "target_frame", "angular_thres", "trans_thres", "rate", "timeout")
"""The fields of a request, in the order of tf2_web_republisher/RepublishTFs."""
TOPICS = ("tf", "tf_static")
ACTION = "tf2_web_republisher/msg/TFSubscriptionAction"
ACTIVE = 1  # actionlib_msgs/GoalStatus
MOST = 100  # maximum number of simultaneous requests
MOST_FRAMES = 1000
FRAMES_DEEP = 64
LONGEST_NAME = 256  # for frame and goal names; longer names are skipped or refused


@dataclass(frozen=True)
class Transform:
    """The pose of one frame in another: translation_m (3,), rotation, and the header of the last link in the chain.

    rotation_xyzw (4,): a unit quaternion.
    """

    translation_m: NDArray[np.float64]
    rotation_xyzw: NDArray[np.float64]
    stamp: Any = None

    def __mul__(self, other: Transform) -> Transform:
        """Chain transforms: a_from_b * b_from_c."""
        moved = self.translation_m + turned(self.rotation_xyzw, other.translation_m)
        return Transform(moved, product(self.rotation_xyzw, other.rotation_xyzw), other.stamp or self.stamp)

    def inverse(self) -> Transform:
        """Return the inverse transform: b_from_a for a_from_b."""
        back = self.rotation_xyzw * CONJUGATE
        return Transform(-turned(back, self.translation_m), back, self.stamp)


CONJUGATE = np.array([-1.0, -1.0, -1.0, 1.0])
IDENTITY = Transform(np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]))


@dataclass(eq=False)
class Request:
    """A client's request, and the last transform sent for each frame. goal_id: the action goal's id, or ""."""

    topic: Topic
    frames: list[str]
    target: str
    angle_rad: float
    distance_m: float
    period_s: float
    patience_s: float
    wanted_s: float
    goal_id: str = ""
    sent: dict[str, Transform] = field(default_factory=dict)


class TfRepublisher:
    """While there are requests, stores the latest transform from each frame to its parent, and publishes changes."""

    def __init__(self, graph: Graph, loop: asyncio.AbstractEventLoop) -> None:
        self._graph = graph
        self._loop = loop
        self._parents: dict[str, tuple[str, Any]] = {}  # parent, and the stamped transform, converted on demand
        self._requests: list[Request] = []
        self._numbers = itertools.count()
        graph.nodes[OWNER] = None
        graph.advertise_service(OWNER, SERVICE, "tf2_web_republisher/RepublishTFs", self._serve)
        node = OWNER.lstrip("/")
        self._feedback = graph.advertise(OWNER, f"{node}/feedback", f"{ACTION}Feedback")
        graph.subscribe(OWNER, "goal", f"{node}/goal", f"{ACTION}Goal", self._accept_goal)
        graph.subscribe(OWNER, "cancel", f"{node}/cancel", "actionlib_msgs/msg/GoalID", self._cancel_goal)

    def close(self) -> None:
        """End all requests."""
        self._requests.clear()

    def _serve(self, arguments: Any, reply: Reply, caller: str) -> None:
        name = f"tf_repub_{next(self._numbers)}"
        request = _read_request(arguments, Topic(name))
        self._begin(request)
        request.topic = self._graph.advertise(OWNER, name, "tf2_web_republisher/msg/TFArray")
        reply(True, {"topic_name": f"/{name}"})

    def _accept_goal(self, sample: Sample) -> None:
        goal = to_plain(sample.message.goal)
        self._begin(_read_request(goal, self._feedback, sample.message.goal_id.id or f"goal {next(self._numbers)}"))

    def _cancel_goal(self, sample: Sample) -> None:
        for request in [request for request in self._requests if request.goal_id == sample.message.id != ""]:
            self._end(request)

    def _begin(self, request: Request) -> None:
        if len(self._requests) >= MOST:
            raise ValueError(f"{MOST} tf requests are active, the maximum")
        if not self._requests:
            for topic in TOPICS:
                self._graph.subscribe(OWNER, topic, topic, "tf2_msgs/msg/TFMessage", self._learn)
        self._requests.append(request)
        self._loop.call_soon(self._tick, request)

    def _learn(self, sample: Sample) -> None:
        for stamped in sample.message.transforms:
            child, parent = stamped.child_frame_id.lstrip("/"), stamped.header.frame_id.lstrip("/")
            is_new = child not in self._parents
            if (
                len(child) > LONGEST_NAME
                or len(parent) > LONGEST_NAME
                or (is_new and len(self._parents) >= MOST_FRAMES)
            ):
                continue
            turn = stamped.transform.rotation
            if 0.25 < turn.x**2 + turn.y**2 + turn.z**2 + turn.w**2 < 4.0:  # otherwise it is not a rotation
                self._parents[child] = parent, stamped

    def _tick(self, request: Request) -> None:
        """Publish changes, and schedule the next tick unless there have been no subscribers for a while."""
        if request not in self._requests:
            return
        now_s = time.monotonic()
        if request.topic.sinks:
            request.wanted_s = now_s
            self._publish(request)
        elif now_s - request.wanted_s > request.patience_s:
            self._end(request)
            return
        self._loop.call_later(request.period_s, self._tick, request)

    def _end(self, request: Request) -> None:
        self._requests.remove(request)
        if not request.goal_id:
            self._graph.unadvertise(OWNER, request.topic.name)
        if not self._requests:
            for topic in TOPICS:
                self._graph.unsubscribe(OWNER, topic, topic)

    def _publish(self, request: Request) -> None:
        changed = []
        for frame in request.frames:
            found = self._find(request.target, frame)
            if found is not None and _differs(found, request.sent.get(frame), request):
                request.sent[frame] = found
                changed.append(_stamped(request.target, frame, found))
        if not changed:
            return
        if request.goal_id:
            message = default_message(f"{ACTION}Feedback")
            message.status.goal_id.id, message.status.status = request.goal_id, ACTIVE
            message.feedback.transforms = changed
        else:
            message = default_message("tf2_web_republisher/msg/TFArray")
            message.transforms = changed
        self._graph.publish(request.topic, Sample(message))

    def _find(self, target: str, frame: str) -> Transform | None:
        """Return target_from_frame through their common ancestor, or None if they have none."""
        of_target, of_frame = self._ancestors(target), self._ancestors(frame)
        for ancestor, from_frame in of_frame.items():
            if ancestor in of_target:
                return of_target[ancestor].inverse() * from_frame
        return None

    def _ancestors(self, frame: str) -> dict[str, Transform]:
        """Return ancestor_from_frame for the frame and all its ancestors, nearest first."""
        found = {frame: IDENTITY}
        ancestor, transform = frame, IDENTITY
        while ancestor in self._parents and len(found) < FRAMES_DEEP:
            ancestor, stamped = self._parents[ancestor]
            if ancestor in found:
                break  # a loop
            transform = _transform(stamped) * transform
            found[ancestor] = transform
        return found


def _transform(stamped: Any) -> Transform:
    moved, turn = stamped.transform.translation, stamped.transform.rotation
    rotation = np.array([turn.x, turn.y, turn.z, turn.w])
    return Transform(np.array([moved.x, moved.y, moved.z]), rotation / np.linalg.norm(rotation), stamped.header)


def offer_tf(graph: Graph, loop: asyncio.AbstractEventLoop) -> TfRepublisher:
    """Offer the tf2_web_republisher service and action in a graph."""
    return TfRepublisher(graph, loop)


def _read_request(arguments: Any, topic: Topic, goal_id: str = "") -> Request:
    """Parse a request from call arguments or a goal. Raises ValueError."""
    if isinstance(arguments, list):
        arguments = by_field(SERVICE, FIELDS, arguments)
    if not isinstance(arguments, dict):
        raise ValueError("args: must be an object or a list")
    frames, target = arguments.get("source_frames"), arguments.get("target_frame")
    if not isinstance(frames, list) or not all(isinstance(frame, str) for frame in frames) or len(frames) > 100:
        raise ValueError("args.source_frames: must be a list of 100 frames at most")
    if not isinstance(target, str):
        raise ValueError("args.target_frame: must be a frame")
    longest = max(len(name) for name in (*frames, target, goal_id))
    if longest > LONGEST_NAME:
        raise ValueError(f"args: a name of {longest} characters: must have {LONGEST_NAME} at most")
    timeout = arguments.get("timeout")
    patience_s = 2.0
    if isinstance(timeout, dict):
        patience_s = _number(timeout, "secs", timeout.get("sec", 2)) + 1e-9 * _number(timeout, "nsecs", 0)
    return Request(
        topic,
        frames=[frame.lstrip("/") for frame in frames],
        target=target.lstrip("/"),
        angle_rad=_number(arguments, "angular_thres", 0.0),
        distance_m=_number(arguments, "trans_thres", 0.0),
        period_s=1.0 / min(max(_number(arguments, "rate", 10.0), 0.1), 100.0),
        patience_s=min(max(patience_s, 0.1), 60.0),
        wanted_s=time.monotonic(),
        goal_id=goal_id,
    )


def _number(values: dict[str, Any], key: str, default: float) -> float:
    value = values.get(key, default)
    if not is_number(value):
        raise ValueError(f"args.{key} = {shortened(value)}: must be a number")
    return float(value)


def _differs(new: Transform, old: Transform | None, request: Request) -> bool:
    if old is None:
        return True
    distance_m = float(np.linalg.norm(new.translation_m - old.translation_m))
    *axis, w = product(old.rotation_xyzw * CONJUGATE, new.rotation_xyzw).tolist()
    angle_rad = 2.0 * math.atan2(math.hypot(*axis), abs(w))
    return distance_m > request.distance_m or angle_rad > request.angle_rad


def _stamped(target: str, frame: str, transform: Transform) -> Any:
    message = default_message("geometry_msgs/msg/TransformStamped")
    message.header.frame_id, message.child_frame_id = target, frame
    if transform.stamp is not None:
        message.header.stamp = transform.stamp.stamp
    translation, rotation = message.transform.translation, message.transform.rotation
    translation.x, translation.y, translation.z = (float(v) for v in transform.translation_m)
    rotation.x, rotation.y, rotation.z, rotation.w = (float(v) for v in transform.rotation_xyzw)
    return message
