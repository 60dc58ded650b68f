"""A session of Foxglove's protocol with one client. It handles frames and fills an outbox, without a transport."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, Protocol

from uwsim.bridges.doors.conversation import Frame
from uwsim.bridges.foxglove import protocol
from uwsim.bridges.foxglove.outbox import Outbox
from uwsim.bridges.foxglove.protocol import Call
from uwsim.channels import Channel
from uwsim.channels.calls.parameter_table import UNSET, ParameterTable

LISTS_MAX = 1000  # entries in a list in one frame, and channels advertised by one client
TEXT_BYTES_MAX = 1 << 17  # size limit of a JSON frame: the app's lists, including schemas, take about 10 kB
MISTAKES_SHOWN = 10  # per frame
CALLS_MAX = 32  # unanswered calls per client
MESSAGE_BYTES_MAX = 1 << 14  # size limit of a command or a request: decoding 16 kB of JSON takes up to 0.3 s
NAME_MAX = 200

logger = logging.getLogger("uwsim.foxglove")


class Served(Protocol):
    """The part of FoxgloveServer that a session uses."""

    inputs: dict[str, Channel]

    @property
    def parameters(self) -> ParameterTable:
        """The simulator's parameters."""

    @property
    def command_topics(self) -> str:
        """The command topics, as text."""

    def subscribe(self, session: Session, offer_id: int) -> None:
        """Start sending a topic's messages."""

    def unsubscribe(self, session: Session, offer_id: int) -> None:
        """Stop sending a topic's messages."""

    def command(self, channel: Channel, encoding: str, data: bytes) -> None:
        """Apply a command."""

    def relinquish(self, channel: Channel) -> None:
        """Note that a session has stopped advertising commands."""

    def is_vital(self, call: Call) -> bool:
        """Return whether a call is of a vital service, which other calls must not hinder."""

    def answer(self, call: Call, reply: Callable[[str | bytes], None]) -> None:
        """Call a service."""

    def set_parameters(self, changes: Mapping[str, Any], done: Callable[[str | None], object]) -> None:
        """Set parameters."""


class Session:
    """A session with one client. subscriptions: the client's subscription numbers, by topic number."""

    def __init__(self, server: Served, outbox: Outbox) -> None:
        self._server = server
        self.outbox = outbox
        self.subscriptions: dict[int, int] = {}
        # None: advertised with an error that has been reported
        self.advertised: dict[int, tuple[Channel, str] | None] = {}
        self._open_calls = 0
        self._watched: dict[str, Any] = {}  # the latest value sent of each parameter that the client subscribes to

    async def take(self, frame: Frame) -> float:
        """Handle a frame; return the CPU time [s] spent."""
        begun_s = time.thread_time()  # CPU time of this thread only, not of others sharing the core
        self.receive(frame)
        return time.thread_time() - begun_s

    async def next_frame(self) -> tuple[Frame | None, float | None]:
        """Return the next frame to send, or None."""
        return self.outbox.take(), None

    def receive(self, frame: Frame) -> None:
        """Handle a frame. Errors are reported to the client as a status, never raised."""
        try:
            if isinstance(frame, str):
                if len(frame) > TEXT_BYTES_MAX:
                    raise ValueError(f"frame: {len(frame)} characters: must be {TEXT_BYTES_MAX} at most")
                self._perform(protocol.read_json(frame))
            else:
                self._receive(protocol.read_binary(frame))
        except (ValueError, RuntimeError) as error:
            self.complain(str(error))
        except Exception:
            logger.exception("a frame that we did not foresee")
            self.complain("the server failed at this operation", protocol.ERROR)

    def complain(self, text: str, level: int = protocol.WARNING) -> None:
        """Report a problem to be displayed by the app."""
        logger.info("%s", text)
        self.outbox.reply(protocol.status(level, text))

    def close(self) -> None:
        """End the session. Nothing more is sent, and its command channels are relinquished."""
        self.outbox.close()
        for offer_id in list(self.subscriptions):
            self._server.unsubscribe(self, offer_id)
        self.subscriptions.clear()
        for channel_id in list(self.advertised):
            self._unadvertise(channel_id)

    def _perform(self, operation: dict[str, Any]) -> None:
        name = operation.get("op")
        if isinstance(name, str) and name in self._requests:
            self._requests[name](self, operation)
            return
        if not isinstance(name, str) or name not in self._operations:
            raise ValueError(f"op = {name!r:.40}: must be one of {', '.join((*self._operations, *self._requests))}")
        key, kind, perform = self._operations[name]
        entries = operation.get(key)
        if not isinstance(entries, list) or len(entries) > LISTS_MAX or {type(entry) for entry in entries} - {kind}:
            raise ValueError(f"{name}.{key}: must be a list of up to {LISTS_MAX} of {kind.__name__}")
        mistakes = []
        for entry in entries:
            try:
                perform(self, entry)
            except (ValueError, RuntimeError) as error:
                mistakes.append(str(error))
        for text in mistakes[:MISTAKES_SHOWN]:
            self.complain(text)

    def _receive(self, received: protocol.Publication | Call) -> None:
        if isinstance(received, Call):
            self._call(received)
            return
        if received.channel_id not in self.advertised:
            raise ValueError(f"channel {received.channel_id}: you have not advertised it")
        found = self.advertised[received.channel_id]
        if found is None:
            return  # its error was reported when it was advertised
        channel, encoding = found
        try:
            _check_size(received.data)
            self._server.command(channel, encoding, received.data)
        except (ValueError, RuntimeError) as error:
            self.complain(f"/{channel.name}: {error}")

    def _subscribe(self, entry: dict[str, Any]) -> None:
        number, offer_id = _number(entry, "id"), _number(entry, "channelId")
        if number in self.subscriptions.values() or offer_id in self.subscriptions:
            raise ValueError(f"subscription {number} of channel {offer_id}: the number or channel is already in use")
        if not 0 <= number < 1 << 32:
            raise ValueError(f"subscription {number}: must be in [0, 2^32)")
        self.subscriptions[offer_id] = number
        try:
            self._server.subscribe(self, offer_id)
        except (ValueError, RuntimeError):
            del self.subscriptions[offer_id]
            raise

    def _unsubscribe(self, number: int) -> None:
        offer_id = next((offer for offer, own in self.subscriptions.items() if own == number), None)
        if offer_id is not None:
            self._server.unsubscribe(self, offer_id)
            del self.subscriptions[offer_id]

    def _advertise(self, entry: dict[str, Any]) -> None:
        number, topic = _number(entry, "id"), _text(entry, "topic")
        encoding, kind = _text(entry, "encoding"), _text(entry, "schemaName")
        if number in self.advertised or len(self.advertised) >= LISTS_MAX:
            raise ValueError(f"channel {number}: already advertised, or {LISTS_MAX} channels are, the maximum")
        self.advertised[number] = None
        target = self._server.inputs.get(topic.lstrip("/"))
        if target is None:
            raise ValueError(f"topic '{topic}': must be a command topic: {self._server.command_topics}")
        if encoding not in protocol.ENCODINGS:
            raise ValueError(f"topic '{topic}': encoding '{encoding}': must be one of {', '.join(protocol.ENCODINGS)}")
        if _full(kind) != target.type:
            raise ValueError(f"topic '{topic}' is {target.type}, not {kind}")
        self.advertised[number] = target, encoding

    def _unadvertise(self, number: int) -> None:
        if number not in self.advertised:
            raise ValueError(f"channel {number}: you have not advertised it")
        found = self.advertised.pop(number)
        if found is not None:
            self._server.relinquish(found[0])

    def _call(self, call: Call) -> None:
        def reply(frame: str | bytes) -> None:
            self._open_calls -= 1
            self.outbox.reply(frame)

        try:
            _check_size(call.data)
            if call.encoding != "json":
                raise ValueError(f"encoding = '{call.encoding}': must be json")
            if self._open_calls >= CALLS_MAX * (2 if self._server.is_vital(call) else 1):
                raise ValueError(f"{CALLS_MAX} calls are still unanswered, the maximum")
            self._server.answer(call, reply)
            self._open_calls += 1
        except (ValueError, RuntimeError) as error:
            self.outbox.reply(protocol.call_failure(call, str(error)))

    def _get_parameters(self, operation: dict[str, Any]) -> None:
        names = _names(operation)
        self._send_parameters(names, _request_id(operation))
        for name in [name for name in names if name not in self._server.parameters.own][:MISTAKES_SHOWN]:
            self.complain(f"parameter '{name}': no parameter has this name")

    def _set_parameters(self, operation: dict[str, Any]) -> None:
        entries, request = operation.get("parameters"), _request_id(operation)
        if not isinstance(entries, list) or len(entries) > LISTS_MAX or {type(entry) for entry in entries} - {dict}:
            raise ValueError(f"setParameters.parameters: must be a list of up to {LISTS_MAX} objects")
        changes = {_text(entry, "name"): entry.get("value", UNSET) for entry in entries}

        def done(error: str | None) -> None:
            self._open_calls -= 1
            if error is not None:
                self.complain(error)
            if request is not None:
                self._send_parameters(list(changes), request)

        if self._open_calls >= CALLS_MAX:
            raise ValueError(f"{CALLS_MAX} calls are still unanswered, the maximum")
        self._server.set_parameters(changes, done)
        self._open_calls += 1

    def _subscribe_parameters(self, operation: dict[str, Any]) -> None:
        self._watched |= self._server.parameters.values(_names(operation))

    def _unsubscribe_parameters(self, operation: dict[str, Any]) -> None:
        names = _names(operation)
        self._watched = {name: value for name, value in self._watched.items() if names and name not in names}

    def send_parameters(self) -> None:
        """Send the parameters that the client subscribes to and that have changed."""
        if not self._watched:
            return
        now = self._server.parameters.values(self._watched)
        changed = {name: value for name, value in now.items() if value != self._watched[name]}
        if changed:
            self._watched |= changed
            self.outbox.reply(protocol.parameter_values([protocol.described(*one) for one in changed.items()]))

    def _send_parameters(self, names: list[str], request: str | None) -> None:
        values = self._server.parameters.values(names)
        self.outbox.reply(protocol.parameter_values([protocol.described(*one) for one in values.items()], request))

    _requests: ClassVar[dict[str, Callable[[Session, dict[str, Any]], None]]] = {
        "getParameters": _get_parameters,
        "setParameters": _set_parameters,
        "subscribeParameterUpdates": _subscribe_parameters,
        "unsubscribeParameterUpdates": _unsubscribe_parameters,
    }
    _operations: ClassVar[dict[str, tuple[str, type, Callable[[Session, Any], None]]]] = {
        "subscribe": ("subscriptions", dict, _subscribe),
        "unsubscribe": ("subscriptionIds", int, _unsubscribe),
        "advertise": ("channels", dict, _advertise),
        "unadvertise": ("channelIds", int, _unadvertise),
    }


def _number(entry: dict[str, Any], key: str) -> int:
    found = entry.get(key)
    if type(found) is not int:
        raise ValueError(f"{key} = {found!r:.40}: must be a whole number")
    return found


def _text(entry: dict[str, Any], key: str) -> str:
    found = entry.get(key)
    if not isinstance(found, str) or len(found) > NAME_MAX:
        raise ValueError(f"{key} = {found!r:.40}: must be a string of up to {NAME_MAX} characters")
    return found


def _names(operation: dict[str, Any]) -> list[str]:
    """Return the names in a request; none stands for all parameters."""
    names = operation.get("parameterNames", [])
    if not isinstance(names, list) or len(names) > LISTS_MAX or {type(name) for name in names} - {str}:
        raise ValueError(f"{operation['op']}.parameterNames: must be a list of up to {LISTS_MAX} strings")
    return names


def _request_id(operation: dict[str, Any]) -> str | None:
    return None if operation.get("id") is None else _text(operation, "id")


def _check_size(data: bytes) -> None:
    if len(data) > MESSAGE_BYTES_MAX:
        raise ValueError(f"{len(data)} bytes: must be {MESSAGE_BYTES_MAX} at most")


def _full(name: str) -> str:
    """Return a type name in ROS 2 spelling."""
    return name if "/msg/" in name else name.replace("/", "/msg/", 1)
