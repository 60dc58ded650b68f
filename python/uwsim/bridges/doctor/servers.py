"""Checks whether the ports of `uwsim serve` are free and, if not, which servers use them."""

from __future__ import annotations

import json
import socket
import struct
from http import HTTPStatus

from websockets.exceptions import InvalidStatus, WebSocketException
from websockets.sync.client import connect
from websockets.typing import Subprotocol

from uwsim.base.texts.json_text import json_object
from uwsim.bridges.doctor.finding import Finding

ANSWER_S = 2.0
ARDUSUB_REPEATS_S = 1.2
SERVO_CHANNELS = {struct.pack("<H", 18458): 16, struct.pack("<H", 29569): 32}
"""The number of servo outputs in a packet, by its magic number; see ServoFrame."""
FOXGLOVE = Subprotocol("foxglove.sdk.v1")
LOCKED = "taken, by a server that requires a token, like uwsim serve --token"


def rosbridge_port(port: int) -> Finding:
    """Return a finding about the rosbridge port."""
    what = f"rosbridge, port {port}"
    if not _is_taken(port):
        return Finding(what, "free")
    try:
        nodes = _rosbridge_nodes(port)
    except PermissionError:
        return Finding(what, LOCKED)
    if nodes is None:
        return Finding(what, "taken, but not by a rosbridge", "wrong", "end it, or uwsim serve --port N")
    if "/uwsim" in nodes:
        return Finding(what, "uwsim serves here")
    return Finding(what, f"another rosbridge: {', '.join(nodes)[:60]}", "wrong", "end it, or uwsim serve --port N")


def foxglove_port(port: int) -> Finding:
    """Return a finding about the Foxglove port."""
    what = f"Foxglove, port {port}"
    if not _is_taken(port):
        return Finding(what, "free")
    try:
        with connect(f"ws://127.0.0.1:{port}", subprotocols=[FOXGLOVE], open_timeout=ANSWER_S, max_size=None) as socket:
            name = json_object(socket.recv(ANSWER_S), what).get("name", "")
    except (OSError, ValueError, WebSocketException) as error:
        if _is_locked(error):
            return Finding(what, LOCKED)
        return Finding(what, "taken, but not by a Foxglove server", "note", "end it, or uwsim serve --foxglove-port N")
    return Finding(what, f"{name or 'a Foxglove server'} serves here")


def ardusub_port(port: int, listen_s: float) -> Finding:
    """Return a finding about the UDP port for ArduSub's frames. ArduSub repeats each frame until it is answered."""
    what = f"ArduSub, UDP port {port}"
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        try:
            listener.bind(("127.0.0.1", port))
        except OSError:
            return Finding(what, "taken, for instance by uwsim serve --ardusub")
        listener.settimeout(min(listen_s, ARDUSUB_REPEATS_S))
        try:
            packet = listener.recv(128)
        except TimeoutError:
            return Finding(what, "free, and nothing sends frames to it")
    channels = SERVO_CHANNELS.get(packet[:2])
    if channels is None or len(packet) != 8 + 2 * channels:
        return Finding(what, f"free, but receives packets of {len(packet)} bytes that are not ArduSub's", "note")
    rate_hz, number = struct.unpack_from("<HI", packet, 2)
    found = f"free; an ArduSub waits: frame {number}, {channels} outputs, {rate_hz} Hz"
    return Finding(what, found, "note", "uwsim serve lagoon --ardusub")


def _is_taken(port: int) -> bool:
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as probe:
        probe.settimeout(ANSWER_S)
        return probe.connect_ex(("127.0.0.1", port)) == 0


def _rosbridge_nodes(port: int) -> list[str] | None:
    """Return the node names of the rosbridge on a port, or None if there is no rosbridge. Raises PermissionError."""
    try:
        with connect(f"ws://127.0.0.1:{port}", open_timeout=ANSWER_S, max_size=None) as bridge:
            bridge.send(json.dumps({"op": "call_service", "service": "/rosapi/nodes", "id": "doctor"}))
            for _ in range(10):
                answer = json_object(bridge.recv(ANSWER_S), f"port {port}")
                if answer.get("op") == "service_response":
                    return [str(name) for name in answer.get("values", {}).get("nodes", [])]
    except (OSError, ValueError, AttributeError, WebSocketException) as error:
        if _is_locked(error):
            raise PermissionError(LOCKED) from None
    return None


def _is_locked(error: Exception) -> bool:
    return isinstance(error, InvalidStatus) and error.response.status_code == HTTPStatus.UNAUTHORIZED
