"""Whether the ports that `uwsim serve` listens on are free, or who has them."""

from __future__ import annotations

import json
import socket

from websockets.exceptions import WebSocketException
from websockets.sync.client import connect
from websockets.typing import Subprotocol

from uwsim.doctor.finding import Finding

ANSWER_S = 2.0
FOXGLOVE = Subprotocol("foxglove.sdk.v1")


def rosbridge_port(port: int) -> Finding:
    """Look at the rosbridge's port."""
    what = f"rosbridge, port {port}"
    if not _is_taken(port):
        return Finding(what, "free")
    nodes = _rosbridge_nodes(port)
    if nodes is None:
        return Finding(what, "taken, by something that is no rosbridge", "wrong", "end it, or uwsim serve --port N")
    if "/uwsim" in nodes:
        return Finding(what, "uwsim serves here")
    return Finding(what, f"another rosbridge: {', '.join(nodes)[:60]}", "wrong", "end it, or uwsim serve --port N")


def foxglove_port(port: int) -> Finding:
    """Look at Foxglove's port."""
    what = f"Foxglove, port {port}"
    if not _is_taken(port):
        return Finding(what, "free")
    try:
        with connect(f"ws://127.0.0.1:{port}", subprotocols=[FOXGLOVE], open_timeout=ANSWER_S, max_size=None) as socket:
            name = json.loads(socket.recv(ANSWER_S)).get("name", "")
    except (OSError, ValueError, WebSocketException):
        return Finding(what, "taken, by no Foxglove server", "note", "end it, or uwsim serve --foxglove-port N")
    return Finding(what, f"{name or 'a Foxglove server'} serves here")


def _is_taken(port: int) -> bool:
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as probe:
        probe.settimeout(ANSWER_S)
        return probe.connect_ex(("127.0.0.1", port)) == 0


def _rosbridge_nodes(port: int) -> list[str] | None:
    """Return the names of a rosbridge's nodes, or None if it is none."""
    try:
        with connect(f"ws://127.0.0.1:{port}", open_timeout=ANSWER_S, max_size=None) as bridge:
            bridge.send(json.dumps({"op": "call_service", "service": "/rosapi/nodes", "id": "doctor"}))
            for _ in range(10):
                answer = json.loads(bridge.recv(ANSWER_S))
                if answer.get("op") == "service_response":
                    return [str(name) for name in answer.get("values", {}).get("nodes", [])]
    except (OSError, ValueError, AttributeError, WebSocketException):
        pass
    return None
