"""A stand-in for a ROS 1 rosbridge_server that refuses what rosbridge_library refuses, and reports it as it does.

It reports a refusal on /rosout alone, as rosbridge_library's `Protocol.log` does.
"""

import json
import math
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from websockets.exceptions import ConnectionClosed
from websockets.sync.server import Server, ServerConnection, serve

from uwsim.channels.ros.message_types import Kind, fields, resolve

PACKAGES = {
    "builtin_interfaces", "diagnostic_msgs", "geometry_msgs", "nav_msgs", "rosgraph_msgs", "sensor_msgs", "std_msgs",
    "std_srvs", "tf2_msgs",
}  # fmt: skip
"""The packages of a ROS installation without any of ours."""


class RefusedError(ValueError):
    """The text of a status."""


def checked_type(name: str) -> str:
    """Return a type name if it has two parts, as rosbridge's loader requires."""
    parts = [part for part in name.split("/") if part]
    if len(parts) != 2:
        raise RefusedError(f"{name} is not a valid type string")
    if parts[0] not in PACKAGES:
        raise RefusedError(f"Unable to load the manifest for package {parts[0]}")
    return name


def check(value: Any, kind: Kind, path: str) -> None:
    """Raise RefusedError unless a value fits a field, as rosbridge_library's message_conversion does."""
    if kind.length is not None:
        if kind.base in ("uint8", "char") and isinstance(value, str):
            return
        if not isinstance(value, list):
            raise RefusedError(f"message requires a list for field {path}, but got a {type(value)}")
        for item in value:
            _check_one(item, kind.base, path)
        return
    _check_one(value, kind.base, path)


def _check_one(value: Any, base: str, path: str) -> None:
    if "/" in base:
        if base in ("builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration"):
            return
        if not isinstance(value, dict):
            raise RefusedError(f"Expected a JSON object for {path} but received a {type(value)}")
        known = {field.name: field.kind for field in fields(base, 1)}
        for name, part in value.items():
            if name not in known:
                raise RefusedError(f"Message type {base} does not have a field {path}.{name}")
            check(part, known[name], f"{path}.{name}")
        return
    allowed: tuple[type, ...] = (str,) if base == "string" else (bool, int)
    if base.startswith("float"):
        allowed = (int, float)
    if not isinstance(value, allowed):
        raise RefusedError(f"message requires a {base} for field {path}, but got a {type(value)}")


class StrictRosbridge:
    """The server. published: accepted messages by topic. refused: the log's lines on refusals. services: offered."""

    def __init__(self) -> None:
        self.published: dict[str, list[dict[str, Any]]] = {}
        self.types: dict[str, str] = {}
        self.services: dict[str, str] = {}
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
                try:
                    self._operate(operation, connection)
                except RefusedError as refusal:
                    with self.arrived:
                        self.refused.append(f"{operation['op']}: {refusal}")
                        self.arrived.notify_all()
                    identity = f" [id: {operation['id']}]" if "id" in operation else ""
                    self._log(f"[Client {id(connection)}]{identity} {self.refused[-1]}")
        except ConnectionClosed:
            pass

    def _operate(self, operation: dict[str, Any], connection: ServerConnection) -> None:
        op, topic = operation["op"], str(operation.get("topic", "")).lstrip("/")
        if op == "advertise":
            self.types[topic] = checked_type(operation["type"])
        elif op == "subscribe":
            checked_type(operation["type"])
            with self._lock:
                self._subscribers.append((topic, connection))
        elif op == "advertise_service":
            self.services[operation["service"]] = checked_type(operation["type"])
        elif op == "call_service":
            answer = {"op": "service_response", "id": operation.get("id"), "result": True, "values": {}}
            connection.send(json.dumps(answer))
        elif op == "publish":
            if topic not in self.types:
                raise RefusedError(f"Cannot infer topic type for topic /{topic} as it is not yet advertised")
            _check_one(operation["msg"], resolve(self.types[topic])[0], topic)
            self._relay(topic, operation["msg"])

    def _log(self, text: str) -> None:
        line = {"header": {"seq": 1}, "level": 8, "name": "/rosbridge_websocket", "msg": text}
        self._relay("rosout", line)

    def _relay(self, topic: str, message: dict[str, Any]) -> None:
        text = json.dumps({"op": "publish", "topic": topic, "msg": _with_null(message)})
        with self._lock:
            sinks = [connection for name, connection in self._subscribers if name == topic]
        for sink in sinks:
            sink.send(text)
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
def strict_rosbridge() -> Iterator[StrictRosbridge]:
    """Run a server."""
    found = StrictRosbridge()
    server: Server = serve(found.handle, "127.0.0.1", 0, max_size=None)
    found.url = f"ws://127.0.0.1:{server.socket.getsockname()[1]}"
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield found
    finally:
        server.shutdown()
        thread.join()
