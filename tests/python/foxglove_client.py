"""A client of Foxglove's WebSocket protocol, https://github.com/foxglove/ws-protocol, based only on `websockets`."""

import json
import struct
from contextlib import ExitStack
from typing import Any

from websockets.typing import Subprotocol

from client_socket import connect
from ros2_tools import PATIENCE_S

MESSAGE, TIME, RESPONSE = 1, 2, 3


class FoxgloveClient:
    """A client that subscribes, publishes and calls services.

    channels, services: those the server advertises, by topic and by name.
    """

    def __init__(self, url: str, first: str = "/scene/lake") -> None:
        self._stack = ExitStack()
        protocols = [Subprotocol("foxglove.sdk.v1")]
        connected = connect(url, subprotocols=protocols, max_size=None, open_timeout=PATIENCE_S)
        self.socket = self._stack.enter_context(connected)
        self.channels: dict[str, dict[str, Any]] = {}
        self.services: dict[str, dict[str, Any]] = {}
        self.statuses: list[str] = []
        self.times_ns: list[int] = []
        self._topics: dict[int, str] = {}
        self.until(lambda: self.channels and first in self.channels)

    def __enter__(self) -> "FoxgloveClient":
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def subscribe(self, topic: str) -> None:
        """Subscribe to a topic."""
        number = len(self._topics) + 1
        self._topics[number] = topic
        self._send(op="subscribe", subscriptions=[{"id": number, "channelId": self.channels[topic]["id"]}])

    def next(self, topic: str) -> tuple[int, bytes]:
        """Wait for a message on a topic; return its time [ns] and its bytes."""
        while True:
            found = self._receive()
            if found is not None and found[0] == topic:
                return found[1:]

    def publish(self, topic: str, type_name: str, message: dict[str, Any]) -> None:
        """Publish one message as JSON."""
        self._send(op="advertise", channels=[{"id": 1, "topic": topic, "encoding": "json", "schemaName": type_name}])
        self.socket.send(struct.pack("<BI", MESSAGE, 1) + json.dumps(message).encode())

    def call(self, name: str, request: dict[str, Any]) -> dict[str, Any]:
        """Call a service and return its response."""
        self.until(lambda: name in self.services)
        data = json.dumps(request).encode()
        self.socket.send(struct.pack("<BIII", 2, self.services[name]["id"], 7, 4) + b"json" + data)
        while True:
            frame = self.socket.recv(PATIENCE_S)
            if isinstance(frame, bytes) and frame[0] == RESPONSE:
                return json.loads(frame[13 + 4 :])
            if isinstance(frame, str):
                self._note(json.loads(frame))

    def until(self, condition: Any) -> None:
        """Receive messages until a condition is true."""
        while not condition():
            self._receive()

    def _send(self, **operation: Any) -> None:
        self.socket.send(json.dumps(operation))

    def _receive(self) -> tuple[str, int, bytes] | None:
        frame = self.socket.recv(PATIENCE_S)
        if isinstance(frame, str):
            self._note(json.loads(frame))
        elif frame[0] == MESSAGE:
            number, time_ns = struct.unpack_from("<IQ", frame, 1)
            return self._topics[number], time_ns, frame[13:]
        elif frame[0] == TIME:
            self.times_ns.append(struct.unpack_from("<Q", frame, 1)[0])
        return None

    def _note(self, operation: dict[str, Any]) -> None:
        if operation["op"] == "advertise":
            self.channels |= {channel["topic"]: channel for channel in operation["channels"]}
        elif operation["op"] == "advertiseServices":
            self.services |= {service["name"]: service for service in operation["services"]}
        elif operation["op"] == "status":
            self.statuses.append(operation["message"])
