"""Decoding of a client's frame into a dict: JSON from text, CBOR from bytes.

Excessive frames are refused before they take time or memory.
"""

from __future__ import annotations

import math
import secrets
from collections.abc import Callable
from typing import Any

import cbor2
import orjson

from uwsim.base.texts.json_text import json_value
from uwsim.bridges.rosbridge.json_scan import JsonScan
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.bridges.rosbridge.weigh import walk_cbor, weigh
from uwsim.channels.ros.message_cost import Meter
from uwsim.channels.ros.messages import typed_array

SLOW_CHARACTERS = 200_000
"""The largest size of a frame with NaN or Infinity, which needs a decoder that is five times slower."""
SMALL_CHARACTERS = 1 << 17
"""Larger frames are decoded in pieces: a decoder's call blocks all other threads, by 20 to 80 ns for each value."""
PIECE_CHARACTERS = 1 << 16  # elements in a list of numbers
LONG_LIST = 256  # characters
REST_VALUES = 150_000  # outside long lists, decoded in one call
MARK = secrets.token_hex(16)  # identifies the place of a long list; a client cannot guess it


def parse(frame: str | bytes, nesting: int) -> dict[str, Any]:
    """Decode the object in a frame from a trusted peer. Raises ValueError with the reason if this fails."""
    if isinstance(frame, bytes):
        walk_cbor(frame, nesting, math.inf)
    return _decode(frame, nesting, bounded=False)


def read(frame: str | bytes, limits: Limits, pause: Callable[[], None] | None = None) -> tuple[dict[str, Any], Meter]:
    """Decode the object in a client's frame, and return it with a meter for its further processing.

    pause: passed to the meter. Raises ValueError for an invalid or oversized frame.
    """
    weight = weigh(frame, limits)
    meter = Meter(limits.cost_of(len(frame)), weight.bytes, limits.objects, pause)
    meter.pause()
    operation = _decode(frame, limits.nesting, remembers=weight.remembers)
    meter.pause()
    return operation, meter


def parse_value(text: str, limits: Limits) -> Any:
    """Decode a value of any type from a client's JSON string. Raises ValueError."""
    value = _from_json(text, remembers=weigh(text, limits).remembers)
    check_nesting(value, limits.nesting)
    return value


def _decode(frame: str | bytes, nesting: int, *, remembers: bool = False, bounded: bool = True) -> dict[str, Any]:
    value = _from_cbor(frame) if isinstance(frame, bytes) else _from_json(frame, remembers=remembers, bounded=bounded)
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


def _from_json(text: str, *, remembers: bool = False, bounded: bool = True) -> Any:
    """Decode JSON text. remembers: share one string among repeated keys, and build no intermediate tree.

    bounded: refuse text that takes long to decode in one call.
    """
    if not remembers:
        try:
            return orjson.loads(text) if len(text) <= SMALL_CHARACTERS else _in_pieces(text, bounded=bounded)
        except orjson.JSONDecodeError as error:
            if "NaN" not in text and "Infinity" not in text:
                raise ValueError(f"frame: not JSON ({error if len(text) <= SMALL_CHARACTERS else error.msg})") from None
        if bounded and len(text) > SLOW_CHARACTERS:
            raise ValueError(
                f"frame: {len(text)} bytes with NaN or Infinity: must be {SLOW_CHARACTERS} at most; null is NaN"
            )
    return json_value(text, "frame")


def _in_pieces(text: str, *, bounded: bool) -> Any:
    """Decode JSON text: first its long lists of numbers, in pieces, then the rest with marks in place of the lists."""
    data = text.encode()
    places = JsonScan(data).flat_lists(LONG_LIST)
    lists = [_list_in_pieces(data[first + 1 : last]) for first, last in places]
    rest, end = bytearray(), 0
    for k, (first, last) in enumerate(places):
        rest += data[end:first] + f'["{MARK}{k}"]'.encode()
        end = last + 1
    rest += data[end:]
    if bounded and rest.count(b",") > REST_VALUES:
        count = JsonScan(bytes(rest)).count(",")
        if count > REST_VALUES:
            raise ValueError(f"frame: {count} values outside long lists of numbers: must be {REST_VALUES} at most")
    whole = [orjson.loads(rest)]
    _put_back(whole, lists)
    return whole[0]


def _list_in_pieces(numbers: bytes) -> list[Any]:
    values: list[Any] = []
    at = 0
    while at >= 0:
        end = numbers.find(b",", at + PIECE_CHARACTERS)
        piece = orjson.loads(b"[%b]" % numbers[at : end if end >= 0 else len(numbers)])
        if not piece and len(numbers) > PIECE_CHARACTERS:
            raise orjson.JSONDecodeError("a list with nothing between two commas", "", 0)
        values += piece
        at = end + 1 or -1
    return values


def _put_back(whole: list[Any], lists: list[list[Any]]) -> None:
    """Replace the marks with the lists that they stand for."""
    containers: list[Any] = [whole]
    while containers:
        container = containers.pop()
        for key, part in container.items() if isinstance(container, dict) else enumerate(container):
            if isinstance(part, list) and len(part) == 1 and isinstance(part[0], str) and part[0].startswith(MARK):
                container[key] = lists[int(part[0].removeprefix(MARK))]
            elif isinstance(part, dict | list):
                containers.append(part)


def _from_cbor(data: bytes) -> Any:
    """Decode data already validated by walk_cbor."""
    try:
        return cbor2.loads(data, tag_hook=_array_of)
    except Exception as error:  # cbor2's own errors, and those that typed_array raises inside it
        raise ValueError(f"frame: not CBOR ({error})") from None


def _array_of(*arguments: Any) -> Any:
    """Convert a tag to an array. Depending on its version, cbor2 passes the tag as the first or the last argument."""
    return typed_array(next(a for a in arguments if isinstance(a, cbor2.CBORTag)))
