"""Decoding of a client's frame into a dict: JSON from text, CBOR from bytes.

A frame's values take a bounded multiple of its size, since the size and the number of lists and objects are limited.
"""

from __future__ import annotations

import math
from typing import Any

import cbor2
import orjson

from uwsim.base.texts.json_text import json_value
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.channels.ros.messages import typed_array

SLOW_CHARACTERS = 200_000
"""The largest size of a frame with NaN or Infinity, which needs a decoder that is five times slower."""
ITEMS_PER_OBJECT = 5  # limit for CBOR, whose walk takes a microsecond per item
TYPED_ARRAYS = range(64, 88)  # RFC 8746; cbor2 would convert other tags to numbers, patterns and references
STRINGS, CONTAINERS, MAP, TAG = (2, 3), (4, 5), 5, 6  # major types, RFC 8949, section 3.1


def parse(frame: str | bytes, nesting: int) -> dict[str, Any]:
    """Decode the object in a frame from a trusted peer. Raises ValueError with the reason if this fails."""
    return _object(_decode(frame, nesting, math.inf, math.inf))


def read(frame: str | bytes, limits: Limits) -> dict[str, Any]:
    """Decode the object in a client's frame. Raises ValueError for an invalid or oversized frame."""
    return _object(_decode(frame, limits.nesting, limits.objects, SLOW_CHARACTERS))


def parse_value(text: str, limits: Limits) -> Any:
    """Decode a value of any type from a client's JSON string. Raises ValueError."""
    return _decode(text, limits.nesting, limits.objects, SLOW_CHARACTERS)


def _object(value: Any) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise ValueError("frame: must be a JSON object, or a CBOR map")
    return value


def _decode(frame: str | bytes, nesting: int, objects: float, slow_characters: float) -> Any:
    if isinstance(frame, bytes):
        walk_cbor(frame, nesting, ITEMS_PER_OBJECT * objects)
        return _from_cbor(frame)
    brackets = frame.count("{") + frame.count("[")
    if brackets > objects:
        raise ValueError(f"frame: {brackets} lists and objects: must be {objects} at most")
    value = _from_json(frame, slow_characters)
    if brackets > nesting:
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


def _from_json(text: str, slow_characters: float) -> Any:
    try:
        return orjson.loads(text)
    except orjson.JSONDecodeError as error:
        if "NaN" not in text and "Infinity" not in text:
            raise ValueError(f"frame: not JSON ({error})") from None
    if len(text) > slow_characters:
        raise ValueError(
            f"frame: {len(text)} bytes with NaN or Infinity: must be {slow_characters} at most; null is NaN"
        )
    return json_value(text, "frame")


def walk_cbor(data: bytes, nesting: int, items: float) -> None:
    """Check CBOR (RFC 8949, appendix C) before it is decoded: its lengths, depth, number of items, and tags.

    Raises ValueError, at the latest where there are too many items.
    """
    at, size, count = 0, len(data), 0
    left = [1]  # items of the frame, and of each container around the present place
    while left:
        if left[-1] == 0:
            left.pop()
            continue
        if at >= size:
            raise ValueError("frame: truncated CBOR")
        left[-1] -= 1
        major, info, at = data[at] >> 5, data[at] & 31, at + 1
        if info > 27:
            raise ValueError("frame: CBOR of indefinite length, which is not accepted")
        width = 1 << (info - 24) if info >= 24 else 0
        argument = int.from_bytes(data[at : at + width], "big") if width else info
        at += width
        if major in STRINGS:
            at += argument
        elif major in CONTAINERS:
            if argument > size - at:  # an item takes at least one byte
                raise ValueError("frame: CBOR that announces more items than it has bytes")
            left.append(argument * (2 if major == MAP else 1))
            count += left[-1]
        elif major == TAG:
            if argument not in TYPED_ARRAYS:
                raise ValueError(f"frame: CBOR tag {argument}: only typed arrays of RFC 8746 are accepted")
            left.append(1)
            count += 1
        if count > items:
            raise ValueError(f"frame: CBOR of more than {items} items")
        if at > size:
            raise ValueError("frame: truncated CBOR")
        if len(left) > 2 * nesting + 2:
            raise ValueError(f"frame: nested more than {nesting} deep")
    if at != size:
        raise ValueError("frame: CBOR followed by further bytes")


def _from_cbor(data: bytes) -> Any:
    """Decode data already validated by walk_cbor."""
    try:
        return cbor2.loads(data, tag_hook=_array_of)
    except Exception as error:  # cbor2's own errors, and those that typed_array raises inside it
        raise ValueError(f"frame: not CBOR ({error})") from None


def _array_of(*arguments: Any) -> Any:
    """Convert a tag to an array. Depending on its version, cbor2 passes the tag as the first or the last argument."""
    return typed_array(next(a for a in arguments if isinstance(a, cbor2.CBORTag)))
