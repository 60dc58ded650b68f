"""A client's frame as a dict: JSON from text, CBOR from bytes. Hostile frames are refused before they cost anything."""

from __future__ import annotations

import json
from typing import Any

import cbor2
import orjson

from uwsim.channels.messages import typed_array

TYPED_ARRAYS = range(64, 88)  # RFC 8746; cbor2 would also make numbers, patterns and references of other tags
_ENDS = 0xFF


def parse(frame: str | bytes, nesting: int) -> dict[str, Any]:
    """Return the object that a frame holds. Raises ValueError in words unless it is one."""
    value = _from_cbor(frame, nesting) if isinstance(frame, bytes) else _from_json(frame)
    if not isinstance(value, dict):
        raise ValueError("frame: must be a JSON object, or a CBOR map")
    # Depth is at most the number of opening brackets: a scan has few, and a thousand numbers that need no look.
    if isinstance(frame, bytes) or frame.count("{") + frame.count("[") > nesting:
        check_nesting(value, nesting)
    return value


def check_nesting(value: Any, nesting: int) -> None:
    """Raise ValueError if lists and objects lie deeper in each other than `nesting`."""
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


def _from_json(text: str) -> Any:
    try:
        return orjson.loads(text)
    except orjson.JSONDecodeError as error:
        if "NaN" not in text and "Infinity" not in text:
            raise ValueError(f"frame: not JSON ({error})") from None
    try:
        return json.loads(text)  # Python's own json writes NaN and Infinity, which JSON lacks: so does roslibpy
    except (ValueError, RecursionError) as error:
        raise ValueError(f"frame: not JSON ({error})") from None


def _from_cbor(data: bytes, nesting: int) -> Any:
    _check_cbor(data, nesting)
    try:
        return cbor2.loads(data, tag_hook=_array_of)
    except Exception as error:  # cbor2's own, and what typed_array raises inside it
        raise ValueError(f"frame: not CBOR ({error})") from None


def _array_of(*arguments: Any) -> Any:
    """Make a tag's array; cbor2 passes the tag last, or first, depending on its version."""
    return typed_array(next(a for a in arguments if isinstance(a, cbor2.CBORTag)))


def _check_cbor(data: bytes, nesting: int) -> None:
    """Walk over the items' heads (RFC 8949, appendix C): lengths fit the data, nesting is bounded, tags are arrays'."""
    at, size = 0, len(data)
    open_items = [1]  # items still to come, of the frame and of each container around the present place
    while open_items:
        if open_items[-1] == 0:
            open_items.pop()
            continue
        if at >= size:
            raise ValueError("frame: CBOR that ends too early")
        open_items[-1] -= 1
        major, info, at = data[at] >> 5, data[at] & 31, at + 1
        if info > 27:
            raise ValueError("frame: CBOR of indefinite length, which is not accepted")
        width = 1 << (info - 24) if info >= 24 else 0
        argument = int.from_bytes(data[at : at + width], "big") if width else info
        at += width
        if major in (2, 3):
            at += argument
        elif major in (4, 5):
            if argument > size - at:  # an item takes a byte at least
                raise ValueError("frame: CBOR that announces more items than it has bytes")
            open_items.append(argument * (2 if major == 5 else 1))
        elif major == 6:
            if argument not in TYPED_ARRAYS:
                raise ValueError(f"frame: CBOR tag {argument}: only typed arrays of RFC 8746 are accepted")
            open_items.append(1)
        if at > size:
            raise ValueError("frame: CBOR that ends too early")
        if len(open_items) > 2 * nesting + 2:
            raise ValueError(f"frame: nested more than {nesting} deep")
    if at != size:
        raise ValueError("frame: CBOR with bytes after its end")
