"""A client's unanswered service calls, and calls from other clients to the services that it offers."""

from __future__ import annotations

import itertools
from typing import Any

from uwsim.bridges.rosbridge.encoding import to_json
from uwsim.bridges.rosbridge.fragments import read_fragment_size
from uwsim.bridges.rosbridge.graph import Graph, Reply, plain_name
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.bridges.rosbridge.names import Names
from uwsim.bridges.rosbridge.outbox import Outbox
from uwsim.channels.ros.message_types import is_unicode, shortened

CALL_BYTES = 1000  # bytes taken by an open call, excluding its arguments


def echoed(name: Any) -> str:
    """Return a name as a client sent it, shortened if an answer cannot carry it."""
    return name if isinstance(name, str) and len(name) <= 256 and is_unicode(name) else shortened(name)


class Call:
    """A call by a client. calls: the client's Calls, or None once the call is answered or the client has left."""

    __slots__ = ("calls", "fragment_size", "response", "size")

    def __init__(self, calls: Calls, response: dict[str, Any], size: int, fragment_size: int | None) -> None:
        self.fragment_size = fragment_size
        self.calls: Calls | None = calls
        self.response = response
        self.size = size

    def answer(self, succeeded: bool, values: Any) -> None:
        """Send the answer if the client is still connected. A second answer is ignored."""
        calls, self.calls = self.calls, None
        if calls is not None:
            calls.answered(self, succeeded, values)


class Calls:
    """A client's calls in both directions. name: the client's name in the graph.

    spent_bytes: the memory that the current operation takes, which may be kept until the answer.
    """

    def __init__(self, graph: Graph, name: str, names: Names, limits: Limits, outbox: Outbox) -> None:
        self._graph, self._name, self._names = graph, name, names
        self._limits = limits
        self._outbox = outbox
        self.spent_bytes = 0
        self._made: set[Call] = set()
        self._received: dict[str, tuple[str, Reply, str]] = {}  # callers, reply functions and services, keyed by our id
        self._numbers = itertools.count(1)
        graph.on_leave.append(self._forget_caller)

    def call_service(self, operation: dict[str, Any]) -> None:
        """Call a service on behalf of the client."""
        name, identity = operation.get("service"), operation.get("id")
        response: dict[str, Any] = {"op": "service_response"}
        if identity is not None:
            response["id"] = identity
        response["service"] = echoed(name)
        reply = self._open(response, read_fragment_size(operation))
        arguments = operation.get("args")
        try:
            self._graph.call(name, {} if arguments in (None, []) else arguments, reply, self._name)  # type: ignore[arg-type]
        except ValueError as error:  # the name itself is invalid
            reply(False, str(error))

    def advertise_service(self, operation: dict[str, Any]) -> None:
        """Register a service that the client offers."""
        name, type_name = operation.get("service"), operation.get("type", "")
        plain = plain_name(name, "service")
        if not isinstance(type_name, str) or len(type_name) > 200:
            raise ValueError(f"type = {shortened(type_name)}: must be the name of a service's type")
        self._names.check_room()

        def serve(arguments: Any, reply: Reply, caller: str) -> None:
            self._receive(str(name), arguments, reply, caller)

        self._graph.advertise_service(self._name, plain, type_name, serve)
        self._names.services.add(plain)

    def unadvertise_service(self, operation: dict[str, Any]) -> None:
        """Remove a service that the client offers."""
        name = plain_name(operation.get("service"), "service")
        self._names.services.discard(name)
        self._graph.unadvertise_service(self._name, name)
        for identity in [identity for identity, (_, _, service) in self._received.items() if service == name]:
            _, reply, _ = self._received.pop(identity)
            self._outbox.kept.give(CALL_BYTES)
            reply(False, f"service '{name}': {self._name} has ceased to offer it")

    def respond(self, operation: dict[str, Any]) -> None:
        """Pass the client's answer to the caller. Raises ValueError if no call is waiting for it."""
        identity = operation.get("id")
        found = self._received.pop(identity, None) if isinstance(identity, str) else None
        if found is None:
            raise ValueError(f"service_response.id = {shortened(identity)}: no such call is waiting for a response")
        self._outbox.kept.give(CALL_BYTES)
        found[1](operation.get("result", True) is not False, operation.get("values", {}))

    def _open(self, response: dict[str, Any], fragment_size: int | None) -> Reply:
        """Register a client's call, and return the function that answers it.

        Raises ValueError if too many are waiting.
        """
        if len(self._made) >= self._limits.open_calls:
            raise ValueError(f"{self._limits.open_calls} of your calls are waiting for responses, the maximum")
        call = Call(self, response, CALL_BYTES + self.spent_bytes, fragment_size)
        if not self._outbox.kept.has(call.size):
            raise ValueError("no room to keep the call: too much waits for you")
        self._outbox.kept.take(call.size)
        self._made.add(call)
        return call.answer

    def answered(self, call: Call, succeeded: bool, values: Any) -> None:
        """Send the answer to a call by the client."""
        self._made.discard(call)
        self._outbox.kept.give(call.size)
        response = call.response | {"values": values, "result": succeeded}
        try:
            frame = to_json(response)
        except ValueError as error:
            frame = to_json(response | {"values": f"values: {error}", "result": False})
        self._outbox.reply(frame, call.fragment_size)

    def _receive(self, service: str, arguments: Any, reply: Reply, caller: str) -> None:
        """Pass a service call to the client that offers the service. Raises ValueError if too many are waiting."""
        if len(self._received) >= self._limits.open_calls:
            raise ValueError(f"service '{service}': {self._limits.open_calls} calls are waiting for its response")
        identity = f"service_request:{service}:{next(self._numbers)}"
        frame = to_json({"op": "call_service", "id": identity, "service": service, "args": arguments})
        self._received[identity] = caller, reply, plain_name(service, "service")
        self._outbox.kept.take(CALL_BYTES)
        self._outbox.reply(frame)

    def _forget_caller(self, name: str) -> None:
        """Stop waiting for answers to a client that has left."""
        for identity in [identity for identity, (caller, _, _) in self._received.items() if caller == name]:
            del self._received[identity]
            self._outbox.kept.give(CALL_BYTES)

    def close(self) -> None:
        """Called when the client has left: fail all calls that wait for its services, and drop its own calls."""
        self._graph.on_leave.remove(self._forget_caller)
        received, self._received = self._received, {}
        for _, reply, _ in received.values():
            reply(False, f"{self._name}, who offers the service, has left")
        for call in self._made:
            call.calls = None
        self._made.clear()
