"""A WebSocket client whose messages need not all be read: by default, 16 unread ones delay its end by ten seconds."""

import json
import time
from functools import partial
from typing import Any

from websockets.sync.client import ClientConnection
from websockets.sync.client import connect as bounded_connect

PATIENCE_S = 180.0
connect = partial(bounded_connect, max_queue=None)


def send(client: ClientConnection, op: str, **fields: Any) -> None:
    client.send(json.dumps({"op": op, **fields}))


def receive(client: ClientConnection, **wanted: Any) -> Any:
    """Return the next operation with these field values."""
    deadline_s = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline_s:
        operation = json.loads(client.recv(PATIENCE_S))
        if wanted.items() <= operation.items():
            return operation
    raise TimeoutError(wanted)


def call(client: ClientConnection, service: str, **args: Any) -> tuple[bool, Any]:
    """Call a service; return its result and its values."""
    send(client, "call_service", service=service, id=service, args=args)
    answer = receive(client, op="service_response", id=service)
    return answer["result"], answer["values"]
