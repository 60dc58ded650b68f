"""Estimates the memory that a client's frame will take once decoded, from a scan of its characters or items.

An empty list is two characters in JSON or one byte in CBOR, but takes seventy bytes in memory. Frames are therefore
scanned first, and a frame that has too many objects or would expand too much is refused before it is decoded.
"""

from __future__ import annotations

import sys
from typing import Any, NamedTuple

import numpy as np

from uwsim.bridges.rosbridge.json_scan import JsonScan
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.channels.ros.message_cost import NUMBER_BYTES, SLOT_BYTES, STRING_BYTES

CONTAINER_BYTES = 184  # an object with up to five members, including its garbage collection overhead
MEMBER_BYTES = 48  # each further member
KEY_BYTES = 176  # a key that the decoder caches
NODE_BYTES = 16  # per value in the tree that orjson builds first (it allocates twelve times the text)
KEY_ENDS = 8  # characters at either end that distinguish keys
ITEMS_PER_OBJECT = 5  # limit for CBOR, whose scan takes a microsecond per item
SLOW_VALUES = 150_000  # limit for a decoder that takes 80 ns per value, in one call
ROUGH_SHARE = 0.5  # share of the limit up to which the rough estimate suffices; the message itself needs the rest
TYPED_ARRAYS = range(64, 88)  # RFC 8746; cbor2 would convert other tags to numbers, patterns and references


class Load(NamedTuple):
    """The contents of a frame.

    values: number of elements and members. strings: number of string values, plus keys that each need a separate
    string. keys: number of cached keys. nodes: number of nodes in an intermediate tree, if there is one.
    """

    containers: int
    strings: int
    members: int
    values: int
    keys: int = 0
    nodes: int = 0

    def decoded_bytes(self, frame: str | bytes) -> int:
        """Return an upper bound on the memory that the frame and its decoded objects take."""
        texts = (2 if isinstance(frame, bytes) or frame.isascii() else 3) * sys.getsizeof(frame)
        own = CONTAINER_BYTES * self.containers + STRING_BYTES * self.strings + KEY_BYTES * self.keys
        many = MEMBER_BYTES * max(0, self.members - 5 * self.containers)
        numbers = max(0, self.values - self.containers - self.strings)
        if isinstance(frame, str):  # Python shares small integers; other numbers have at least three characters
            numbers = min(numbers, max(0, (len(frame) - 2 * numbers) // 2))
        return texts + own + many + SLOT_BYTES * self.values + NUMBER_BYTES * numbers


class Weight(NamedTuple):
    """The maximum memory of a decoded frame.

    remembers: whether the decoder must share repeated keys to stay below it.
    """

    bytes: int
    remembers: bool


def weigh(frame: str | bytes, limits: Limits) -> Weight:
    """Return the memory that a frame will take. Raises ValueError if this is excessive for the size of the frame.

    This also validates CBOR: lengths must fit the data, nesting is limited, and all tags must be typed arrays.
    """
    allowed, remembers = limits.cost_of(len(frame)), False
    if isinstance(frame, bytes):
        load = walk_cbor(frame, limits.nesting, limits.objects)
    else:
        load = _quick_load(frame)
        if _is_too_much(load, frame, limits, ROUGH_SHARE):
            exact, fits = exact_load(frame), not _is_too_much(load, frame, limits)
            shares = exact.members > exact.values // 2  # mostly members of objects, not elements of lists
            remembers = exact.values <= SLOW_VALUES and (shares or not fits)
            if not remembers and not fits and exact.containers <= limits.objects:
                raise ValueError(f"frame: {exact.values} values in many objects: must be {SLOW_VALUES} at most")
            load = exact if remembers or not fits else load
    if load.containers > limits.objects:
        raise ValueError(f"frame: {load.containers} lists and objects: must be {limits.objects} at most")
    if load.strings > limits.strings:
        raise ValueError(f"frame: {load.strings} strings: must be {limits.strings} at most")
    needed = load.decoded_bytes(frame)
    if _is_too_much(load, frame, limits):
        rule = f"must take {allowed / 1e6:.1f} MB of memory at most"
        raise ValueError(f"frame: takes {needed / 1e6:.1f} MB decoded: one of {len(frame)} bytes {rule}")
    return Weight(needed, remembers)


def _is_too_much(load: Load, frame: str | bytes, limits: Limits, share: float = 1.0) -> bool:
    needed = load.decoded_bytes(frame) + NODE_BYTES * load.nodes
    too_many = load.containers > limits.objects or load.strings > limits.strings
    return too_many or needed > share * limits.cost_of(len(frame))


def _quick_load(text: str) -> Load:
    """Return an upper bound that also counts characters inside strings, and counts each key as a separate string."""
    containers = text.count("{") + text.count("[")
    commas, colons, quotes = text.count(","), text.count(":"), text.count('"')
    values = commas + containers + 1
    # Each key is counted as a string, so a value is added for it. Otherwise it would hide a number.
    return Load(containers, quotes // 2, colons, values + quotes // 2, nodes=values + quotes // 2)


def exact_load(text: str) -> Load:
    """Return the load of JSON text, ignoring characters inside its strings."""
    scan = JsonScan(text.encode(errors="replace"))
    data, bounds = scan.characters, np.flatnonzero(scan.quotes)
    containers = scan.count("{[")
    commas = scan.count(",")
    colons = scan.find(":")
    strings = max(0, len(bounds) // 2 - len(colons))
    keys = _distinct_keys(data, bounds, colons)
    return Load(containers, strings, len(colons), commas + containers + 1, keys)


def _distinct_keys(data: Any, bounds: Any, colons: Any) -> int:
    """Return the approximate number of distinct keys, which are compared by their lengths and both ends."""
    closing = np.searchsorted(bounds, colons) - 1
    closing = closing[closing >= 1]
    starts, ends = bounds[closing - 1] + 1, bounds[closing]
    signs = (ends - starts).astype(np.uint64)
    for k in range(KEY_ENDS):
        for place in (starts + k, ends - 1 - k):
            signs = signs * np.uint64(0x9E3779B97F4A7C15) + np.where(
                (place >= starts) & (place < ends), data[np.clip(place, 0, len(data) - 1)], 0
            ).astype(np.uint64)
    return len(np.unique(signs))


def walk_cbor(data: bytes, nesting: float, objects: float) -> Load:
    """Scan the heads of CBOR items (RFC 8949, appendix C).

    This checks the lengths, the nesting depth, and that all tags are typed arrays. Raises ValueError as soon as there
    are more than `objects` lists and maps, or more than five times as many items.
    """
    at, size = 0, len(data)
    containers = strings = members = items = 0
    open_items = [1]  # remaining items of the frame, and of each container around the current position
    while open_items:
        if open_items[-1] == 0:
            open_items.pop()
            continue
        if at >= size:
            raise ValueError("frame: truncated CBOR")
        open_items[-1] -= 1
        items += 1
        major, info, at = data[at] >> 5, data[at] & 31, at + 1
        if info > 27:
            raise ValueError("frame: CBOR of indefinite length, which is not accepted")
        width = 1 << (info - 24) if info >= 24 else 0
        argument = int.from_bytes(data[at : at + width], "big") if width else info
        at += width
        if major in (2, 3):
            at += argument
            strings += 1
        elif major in (4, 5):
            if argument > size - at:  # an item takes at least one byte
                raise ValueError("frame: CBOR that announces more items than it has bytes")
            containers += 1
            count = argument * (2 if major == 5 else 1)
            members += argument if major == 5 else 0
            if containers > objects or items + count > ITEMS_PER_OBJECT * objects:
                most = ITEMS_PER_OBJECT * objects
                raise ValueError(f"frame: CBOR of more than {objects} lists, maps and arrays, or {most} items")
            open_items.append(count)
        elif major == 6:
            if argument not in TYPED_ARRAYS:
                raise ValueError(f"frame: CBOR tag {argument}: only typed arrays of RFC 8746 are accepted")
            containers += 1  # an array takes as much memory as a container
            open_items.append(1)
        if at > size:
            raise ValueError("frame: truncated CBOR")
        if len(open_items) > 2 * nesting + 2:
            raise ValueError(f"frame: nested more than {nesting} deep")
    if at != size:
        raise ValueError("frame: CBOR followed by further bytes")
    return Load(containers, strings, members, items)
