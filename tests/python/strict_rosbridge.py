"""A stand-in for a rosbridge_server of ROS 1 or 2 that refuses what rosbridge_library refuses.

It reports a refusal on /rosout alone, as rosbridge_library's `Protocol.log` does. Subscribers get all fields of its
generation, whatever was published.
"""

import json
import math
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

from websockets.exceptions import ConnectionClosed
from websockets.sync.server import Server, ServerConnection, serve

from uwsim.channels.ros.message_types import Kind, Ros, fields, resolve
from uwsim.channels.ros.messages import default_message, to_plain

PACKAGES = {
    "builtin_interfaces", "diagnostic_msgs", "geometry_msgs", "nav_msgs", "rcl_interfaces", "rosgraph_msgs",
    "sensor_msgs", "std_msgs", "std_srvs", "tf2_msgs",
}  # fmt: skip
"""The packages of a ROS installation without any of ours."""
LEVELS: dict[Ros, dict[str, int]] = {1: {"warn": 4, "error": 8}, 2: {"warn": 30, "error": 40}}
TIMES: dict[Ros, tuple[str, str]] = {1: ("secs", "nsecs"), 2: ("sec", "nanosec")}


class RefusedError(ValueError):
    """The text of a status."""


def filled(value: Any, base: str, ros: Ros) -> Any:
    """Return a message with all fields of a generation."""
    whole = json.loads(json.dumps(to_plain(default_message(base), ros), default=lambda array: array.tolist()))
    for field in fields(base, ros):
        if field.name in value:
            part = value[field.name]
            is_message = field.kind.is_message and field.kind.length is None
            whole[field.name] = filled(part, field.kind.base, ros) if is_message else part
    return whole


class StrictRosbridge:
    """The server, of generation `ros`, with or without a rosapi.

    packages: of the message types that it has. lacks: fields that its types do not have. published: accepted messages
    by topic. refused: the log's lines on refusals. services: offered. parameters: set by rosapi.
    """

    def __init__(self, ros: Ros = 1, *, rosapi: bool = True) -> None:
        self.ros: Ros = ros
        self.has_rosapi = rosapi
        self.packages = set(PACKAGES)
        self.lacks: set[str] = set()
        self.published: dict[str, list[dict[str, Any]]] = {}
        self.types: dict[str, str] = {}
        self.services: dict[str, str] = {}
        self.parameters: dict[str, str] = {}
        self.refused: list[str] = []
        self.arrived = threading.Condition()
        self.url = ""
        self._lock = threading.Lock()
        self._subscribers: list[tuple[str, ServerConnection]] = []

    def handle(self, connection: ServerConnection) -> None:
        """Serve one client."""
        try:
            for frame in connection:
                operation = json.loads(frame)  # which reads NaN and Infinity
                identity = f" [id: {operation['id']}]" if "id" in operation else ""
                try:
                    if warning := self._operate(operation, connection):
                        self._log(f"[Client {id(connection)}] {warning}", "warn")
                except RefusedError as refusal:
                    with self.arrived:
                        self.refused.append(f"{operation['op']}: {refusal}")
                        self.arrived.notify_all()
                    self._log(f"[Client {id(connection)}]{identity} {self.refused[-1]}", "error")
        except ConnectionClosed:
            pass

    def _operate(self, operation: dict[str, Any], connection: ServerConnection) -> str | None:
        """Perform an operation, and return what is warned of."""
        op, topic = operation["op"], str(operation.get("topic", "")).lstrip("/")
        if op == "advertise":
            self.types[topic] = self._checked_type(operation["type"])
        elif op == "subscribe":
            self._checked_type(operation["type"])
            with self._lock:
                self._subscribers.append((operation["topic"], connection))
        elif op == "advertise_service":
            name = operation["service"]
            is_known, self.services[name] = name in self.services, self._checked_type(operation["type"])
            return f"Duplicate service advertised. Overwriting {name}." if is_known else None
        elif op == "call_service":
            answer = self._called(operation)
            connection.send(json.dumps({"op": "service_response", "id": operation.get("id"), **answer}))
            if not answer["result"]:
                raise RefusedError(answer["values"])
        elif op == "publish":
            if topic not in self.types:
                raise RefusedError(f"Cannot infer topic type for topic /{topic} as it is not yet advertised")
            kind = resolve(self.types[topic])[0]
            self._check_one(operation["msg"], kind, topic)
            self._relay(topic, operation["msg"], kind)
        return None

    def _called(self, operation: dict[str, Any]) -> dict[str, Any]:
        """Return a call's result and values."""
        service, arguments = operation["service"], operation.get("args", {})
        values = {
            "/rosapi/get_time": {"time": dict.fromkeys(TIMES[self.ros], 0)},
            "/rosapi/topics": {"topics": [f"/{topic}" for topic in self.types]},
        } | ({"/rosapi/get_ros_version": {"version": 2, "distro": "jazzy"}} if self.ros == 2 else {})
        if self.has_rosapi and service == "/rosapi/set_param":
            self.parameters[arguments["name"]] = arguments["value"]
            return {"result": True, "values": {}}
        if self.has_rosapi and service in values:
            return {"result": True, "values": values[service]}
        return {"result": False, "values": f"Service {service} does not exist"}

    def _checked_type(self, name: str) -> str:
        """Return a type's name if the loader of rosbridge_library finds it: in ROS 1 it must have two parts."""
        parts = [part for part in name.split("/") if part]
        if len(parts) != 2 and not (self.ros == 2 and len(parts) == 3):
            raise RefusedError(f"{name} is not a valid type string")
        if parts[0] not in self.packages:
            raise RefusedError(
                f"Unable to load the manifest for package {parts[0]}" if self.ros == 1 else
                f"Unable to import {parts[0]}.msg from package {parts[0]}"
            )  # fmt: skip
        return name

    def _check(self, value: Any, kind: Kind, path: str) -> None:
        """Raise RefusedError unless a value fits a field, as rosbridge_library's message_conversion does."""
        if kind.length is not None:
            if kind.base in ("uint8", "char") and isinstance(value, str):
                return
            if not isinstance(value, list):
                raise RefusedError(f"message requires a list for field {path}, but got a {type(value)}")
            for item in value:
                self._check_one(item, kind.base, path)
            return
        self._check_one(value, kind.base, path)

    def _check_one(self, value: Any, base: str, path: str) -> None:
        if "/" in base:
            if base in ("builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration"):
                return
            if not isinstance(value, dict):
                raise RefusedError(f"Expected a JSON object for {path} but received a {type(value)}")
            known = {field.name: field.kind for field in fields(base, self.ros) if field.name not in self.lacks}
            for name, part in value.items():
                if name not in known:
                    raise RefusedError(f"Message type {base} does not have a field {path}.{name}")
                self._check(part, known[name], f"{path}.{name}")
            return
        allowed: tuple[type, ...] = (str,) if base == "string" else (bool, int)
        if base.startswith("float"):
            allowed = (int, float)
        if not isinstance(value, allowed):
            raise RefusedError(f"message requires a {base} for field {path}, but got a {type(value)}")

    def _log(self, text: str, level: str) -> None:
        line = {"level": LEVELS[self.ros][level], "name": "/rosbridge_websocket", "msg": text}
        kind = "rosgraph_msgs/msg/Log" if self.ros == 1 else "rcl_interfaces/msg/Log"
        self._relay("rosout", line, kind)

    def _relay(self, topic: str, message: dict[str, Any], kind: str) -> None:
        whole = _with_null(filled(message, kind, self.ros))
        with self._lock:
            sinks = [(name, sink) for name, sink in self._subscribers if name.lstrip("/") == topic]
        for name, sink in sinks:  # with the name as spelled by the subscriber
            with suppress(ConnectionClosed):
                sink.send(json.dumps({"op": "publish", "topic": name, "msg": whole}))
        with self.arrived:
            self.published.setdefault(topic, []).append(message)
            self.arrived.notify_all()

    def wait(self, condition: Any) -> None:
        """Wait for something to arrive."""
        with self.arrived:
            assert self.arrived.wait_for(condition, 60.0), (list(self.published), self.refused)


def _with_null(value: Any) -> Any:
    """Return a message as rosbridge writes it: NaN and infinity are null."""
    if isinstance(value, dict):
        return {name: _with_null(part) for name, part in value.items()}
    if isinstance(value, list):
        return [_with_null(part) for part in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


@contextmanager
def strict_rosbridge(ros: Ros = 1, *, rosapi: bool = True) -> Iterator[StrictRosbridge]:
    """Run a server."""
    found = StrictRosbridge(ros, rosapi=rosapi)
    server: Server = serve(found.handle, "127.0.0.1", 0, max_size=None)
    found.url = f"ws://127.0.0.1:{server.socket.getsockname()[1]}"
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield found
    finally:
        server.shutdown()
        thread.join()
