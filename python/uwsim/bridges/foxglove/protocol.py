"""The server side of Foxglove's WebSocket protocol: conversion between frames and values.

See https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md. Text frames are JSON objects with an `op`. Binary
frames begin with a byte that identifies their kind. All integers are little-endian.
"""

from __future__ import annotations

import struct
from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import orjson

from uwsim.base.texts.json_text import json_object

SUBPROTOCOLS = ("foxglove.sdk.v1", "foxglove.websocket.v1")
CAPABILITIES = ("clientPublish", "services", "time")
OF_PARAMETERS = ("parameters", "parametersSubscribe")  # further capabilities of a live simulator
ENCODINGS = ("cdr", "json")
WARNING, ERROR = 1, 2
MESSAGE, TIME, ANSWER = 1, 2, 3  # binary frames of the server
PUBLISH, CALL = 1, 2  # binary frames of a client
BINARY_SCHEMAS = ("protobuf", "flatbuffer")


@dataclass(frozen=True)
class Offer:
    """A topic to which clients may subscribe. schema: a text in the format schema_encoding, such as ros2msg."""

    id: int
    name: str
    encoding: str
    schema_name: str
    schema_encoding: str
    schema: bytes
    metadata: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Publication:
    """A message from a client on a channel that it advertised."""

    channel_id: int
    data: bytes


@dataclass(frozen=True)
class Call:
    """A client's service call."""

    service_id: int
    call_id: int
    encoding: str
    data: bytes


def server_info(name: str, session: str, *, has_parameters: bool = False) -> str:
    """Return the first frame of a conversation. session: an ID. If the ID changes, the app discards its data."""
    offered = (*CAPABILITIES, *(OF_PARAMETERS if has_parameters else ()))
    return _text("serverInfo", name=name, capabilities=offered, supportedEncodings=ENCODINGS, sessionId=session)


def advertisement(offers: Sequence[Offer]) -> str:
    """Return the frame that advertises topics."""
    channels = [
        {
            "id": offer.id,
            "topic": f"/{offer.name}",
            "encoding": offer.encoding,
            "schemaName": offer.schema_name,
            "schemaEncoding": offer.schema_encoding,
            "schema": _schema_text(offer),
            **({"metadata": offer.metadata} if offer.metadata else {}),
        }
        for offer in offers
    ]
    return _text("advertise", channels=channels)


def services_advertisement(services: Sequence[tuple[int, str, str]]) -> str:
    """Return the frame that advertises services, given as (number, name, type). Requests may be any JSON object."""

    def described(number: int, name: str, kind: str) -> dict[str, Any]:
        schema = {"schemaName": kind, "schemaEncoding": "jsonschema", "schema": '{"type":"object"}'}
        anything = {"encoding": "json", **schema}
        return {"id": number, "name": f"/{name}", "type": kind, "request": anything, "response": anything}

    return _text("advertiseServices", services=[described(*service) for service in services])


def status(level: int, text: str) -> str:
    """Return the frame that reports a problem for the app to display."""
    return _text("status", level=level, message=text)


def parameter_values(parameters: Sequence[dict[str, Any]], request: str | None = None) -> str:
    """Return the frame with parameters, each {name, value, type}. request: the ID of the request to answer, if any."""
    return _text("parameterValues", parameters=parameters, **({} if request is None else {"id": request}))


def call_failure(call: Call, why: str) -> str:
    """Return the frame that reports a failed call."""
    return _text("serviceCallFailure", serviceId=call.service_id, callId=call.call_id, message=why)


def answer(call: Call, response: dict[str, Any]) -> bytes:
    """Return the frame that answers a call in JSON."""
    head = struct.pack("<BIII4s", ANSWER, call.service_id, call.call_id, 4, b"json")
    return head + orjson.dumps(response, default=str)


def message(subscription: int, time_ns: int, data: bytes) -> bytes:
    """Return the frame for a topic message."""
    return struct.pack("<BIQ", MESSAGE, subscription, time_ns) + data


def time(time_ns: int) -> bytes:
    """Return the frame for the simulated time."""
    return struct.pack("<BQ", TIME, time_ns)


def read_binary(frame: bytes) -> Publication | Call:
    """Parse a client's binary frame. Raises ValueError."""
    if frame[:1] == bytes([PUBLISH]) and len(frame) >= 5:
        return Publication(struct.unpack_from("<I", frame, 1)[0], frame[5:])
    if frame[:1] == bytes([CALL]) and len(frame) >= 13:
        service_id, call_id, length = struct.unpack_from("<III", frame, 1)
        encoding, data = frame[13 : 13 + length], frame[13 + length :]
        if len(encoding) == length <= 64:
            return Call(service_id, call_id, encoding.decode("ascii", "replace"), data)
    raise ValueError(
        f"frame: {len(frame)} bytes that begin with {frame[:13].hex() or 'nothing'}: neither a message nor a call"
    )


def read_json(data: str | bytes) -> dict[str, Any]:
    """Parse a JSON object. Empty data is parsed as an empty object. Raises ValueError."""
    return json_object(data or b"{}", f"{data[:60]!r}")


def _text(op: str, **values: Any) -> str:
    return orjson.dumps({"op": op, **values}).decode()


def _schema_text(offer: Offer) -> str:
    if offer.schema_encoding in BINARY_SCHEMAS:
        return b64encode(offer.schema).decode()
    return offer.schema.decode()


def described(name: str, value: Any) -> dict[str, Any]:
    """Return a parameter in the protocol's format, without a value if it has none."""
    if value is None:
        return {"name": name}
    kind: dict[str, str] = {}
    if isinstance(value, float):
        kind = {"type": "float64"}
    elif isinstance(value, list | tuple) and value and all(isinstance(part, float) for part in value):
        kind = {"type": "float64_array"}
    return {"name": name, "value": value, **kind}
