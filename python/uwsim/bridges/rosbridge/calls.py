"""One client's calls of services, and the calls of its own services, that wait for their answers."""

from __future__ import annotations

import itertools
from typing import Any

from uwsim.bridges.rosbridge.encoding import to_json
from uwsim.bridges.rosbridge.graph import Reply
from uwsim.bridges.rosbridge.ledger import Account
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.bridges.rosbridge.outbox import Outbox
from uwsim.channels.message_types import shortened

CALL_BYTES = 1000  # of an open call without its arguments


class Call:
    """A client's call. calls: of the client; None once it has been answered, or the client has left."""

    __slots__ = ("calls", "response", "size")

    def __init__(self, calls: Calls, response: dict[str, Any], size: int) -> None:
        self.calls: Calls | None = calls
        self.response = response
        self.size = size

    def answer(self, succeeded: bool, values: Any) -> None:
        """Send the answer, if the client is there; a second one is ignored."""
        calls, self.calls = self.calls, None
        if calls is not None:
            calls.answered(self, succeeded, values)


class Calls:
    """Both kinds. account: of what is kept until the answer comes."""

    def __init__(self, limits: Limits, account: Account, outbox: Outbox) -> None:
        self._limits = limits
        self._account = account
        self._outbox = outbox
        self._made: set[Call] = set()
        self._received: dict[str, tuple[str, Reply]] = {}  # callers and their replies, by our id
        self._numbers = itertools.count(1)

    def make(self, response: dict[str, Any], size: int) -> Reply:
        """Return what answers a call that the client makes. size: bytes of its arguments. Raises ValueError."""
        if len(self._made) >= self._limits.open_calls:
            raise ValueError(f"{self._limits.open_calls} of your calls wait for answers, which is the most")
        call = Call(self, response, CALL_BYTES + size)
        if not self._account.has_room(call.size):
            raise ValueError("no room to keep the call: too much waits for you, or for all clients")
        self._account.take(call.size)
        self._made.add(call)
        return call.answer

    def answered(self, call: Call, succeeded: bool, values: Any) -> None:
        """Send the answer of a call that the client has made."""
        self._made.discard(call)
        self._account.give(call.size)
        response = call.response | {"values": values, "result": succeeded}
        try:
            frame = to_json(response)
        except ValueError as error:
            frame = to_json(response | {"values": f"values: {error}", "result": False})
        self._outbox.reply(frame)

    def receive(self, service: str, arguments: Any, reply: Reply, caller: str) -> None:
        """Pass a call of one of the client's services on to it. Raises ValueError if too many wait."""
        if len(self._received) >= self._limits.open_calls:
            raise ValueError(f"service '{service}': {self._limits.open_calls} calls wait for its answer")
        identity = f"service_request:{service}:{next(self._numbers)}"
        frame = to_json({"op": "call_service", "id": identity, "service": service, "args": arguments})
        self._received[identity] = caller, reply
        self._account.take(CALL_BYTES)
        self._outbox.reply(frame)

    def respond(self, identity: object, succeeded: bool, values: Any) -> None:
        """Pass the client's answer on to the caller. Raises ValueError if none waits for it."""
        found = self._received.pop(identity, None) if isinstance(identity, str) else None
        if found is None:
            raise ValueError(f"service_response.id = {shortened(identity)}: no such call waits for an answer")
        self._account.give(CALL_BYTES)
        found[1](succeeded, values)

    def forget_caller(self, name: str) -> None:
        """Wait no longer for answers to a client that has left."""
        for identity in [identity for identity, (caller, _) in self._received.items() if caller == name]:
            del self._received[identity]
            self._account.give(CALL_BYTES)

    def close(self, name: str) -> None:
        """Answer all callers that the client has left, and let go of its own calls."""
        received, self._received = self._received, {}
        for _, reply in received.values():
            reply(False, f"{name}, who offers the service, has left")
        for call in self._made:
            call.calls = None
        self._made.clear()
