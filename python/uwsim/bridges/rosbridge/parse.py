"""Decoding of a client's frame to a dict: JSON from text, CBOR from bytes.

Hostile frames are refused before they cost anything.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import Any

import cbor2
import orjson

from uwsim.bridges.rosbridge.limits import Limits
from uwsim.bridges.rosbridge.weigh import walk_cbor, weigh
from uwsim.channels.message_cost import Meter
from uwsim.channels.messages import typed_array

SLOW_BYTES = 200_000
"""The largest size of a frame with NaN or Infinity, which needs a decoder that is five times slower."""


def parse(frame: str | bytes, nesting: int) -> dict[str, Any]:
    """Decode the object in a frame from a trusted peer. Raises ValueError with the reason if this fails."""
    if isinstance(frame, bytes):
        walk_cbor(frame, nesting, math.inf)
    return _decode(frame, nesting, math.inf)


def read(frame: str | bytes, limits: Limits, pause: Callable[[], None] | None = None) -> tuple[dict[str, Any], Meter]:
    """Decode the object in a client's frame; return it, and a meter for further work on it. Raises ValueError.

    pause: passed to the meter.
    """
    weight = weigh(frame, limits)
    meter = Meter(limits.cost_of(len(frame)), weight.bytes, limits.objects, pause)
    meter.pause()
    operation = _decode(frame, limits.nesting, SLOW_BYTES, remembers=weight.remembers)
    meter.pause()
    return operation, meter


def parse_value(text: str, limits: Limits) -> Any:
    """Decode a value of any type from a client's JSON string. Raises ValueError."""
    value = _from_json(text, SLOW_BYTES, remembers=weigh(text, limits).remembers)
    check_nesting(value, limits.nesting)
    return value


def _decode(frame: str | bytes, nesting: int, slow_bytes: float, *, remembers: bool = False) -> dict[str, Any]:
    value = _from_cbor(frame) if isinstance(frame, bytes) else _from_json(frame, slow_bytes, remembers=remembers)
    if not isinstance(value, dict):
        raise ValueError("frame: must be a JSON object, or a CBOR map")
    # The depth is at most the number of opening brackets; a scan has few, so its thousand numbers need no check.
    if isinstance(frame, bytes) or frame.count("{") + frame.count("[") > nesting:
        check_nesting(value, nesting)
    return value


def check_nesting(value: Any, nesting: int) -> None:
    """Raise ValueError if lists and objects are nested more deeply than `nesting`."""
    level = [value]
    for _ in range(nesting + 1):
        containers = [v for v in level if isinstance(v, dict | list)]
        if not containers:
            return
        level = []
        for container in containers:
            parts = container.values() if isinstance(container, dict) else container
            level.extend(part for part in parts if isinstance(part, dict | list))
    raise ValueError(f"frame: nested more than {nesting} deep")


def _from_json(text: str, slow_bytes: float, *, remembers: bool = False) -> Any:
    """Decode JSON text. remembers: share one string among repeated keys, and build no intermediate tree."""
    if not remembers:
        try:
            return orjson.loads(text)
        except orjson.JSONDecodeError as error:
            if "NaN" not in text and "Infinity" not in text:
                raise ValueError(f"frame: not JSON ({error})") from None
        if len(text) > slow_bytes:
            raise ValueError(
                f"frame: {len(text)} bytes with NaN or Infinity: must be {slow_bytes} at most; null is NaN"
            )
    try:
        return json.loads(text)  # like roslibpy, Python's own json accepts NaN and Infinity, which are not part of JSON
    except (ValueError, RecursionError) as error:
        raise ValueError(f"frame: not JSON ({error})") from None


def _from_cbor(data: bytes) -> Any:
    """Decode data that walk_cbor has validated."""
    try:
        return cbor2.loads(data, tag_hook=_array_of)
    except Exception as error:  # cbor2's own errors, and those that typed_array raises inside it
        raise ValueError(f"frame: not CBOR ({error})") from None


def _array_of(*arguments: Any) -> Any:
    """Convert a tag to an array; cbor2 passes the tag first or last, depending on its version."""
    return typed_array(next(a for a in arguments if isinstance(a, cbor2.CBORTag)))
