"""Finds where two recordings diverge: the first tick and channel that differ, the differences, and later ones."""

from __future__ import annotations

import math
from collections import defaultdict, deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from uwsim.channels.ros.message_types import fields
from uwsim.channels.ros.messages import from_bytes
from uwsim.recording.messages import Recorded
from uwsim.recording.reader import Recording

SHOWN = 50  # number of characters of long text that are shown


def differences(kind: str, first: bytes, second: bytes) -> str:
    """Return the first two fields that differ, and by how much, on one line."""
    found = list(_fields(kind, from_bytes(first, kind), from_bytes(second, kind), ""))
    if not found:
        return "bytes that belong to no field"
    more = f", and {len(found) - 2} more fields" if len(found) > 2 else ""
    return ", ".join(found[:2]) + more


def largest(kind: str, first: bytes, second: bytes) -> float:
    """Return the largest finite difference between numbers in two messages, or NaN if there is none.

    Only floating-point numbers are compared, since differences in pictures, counts and text have no magnitude.
    """
    gaps = [gap for gap in _gaps(kind, from_bytes(first, kind), from_bytes(second, kind)) if 0.0 < gap < np.inf]
    return max(gaps, default=np.nan)


def _parts(kind: str, first: Any, second: Any, path: str) -> Iterator[tuple[str, Any, Any]]:
    """Yield the path and both values of every field that is not itself a message."""
    for part in fields(kind, 2):
        if part.attribute is None:
            continue
        a, b = getattr(first, part.attribute), getattr(second, part.attribute)
        name = f"{path}{part.name}"
        if not part.kind.is_message:
            yield name, a, b
        elif part.kind.length is None:
            yield from _parts(part.kind.base, a, b, f"{name}.")
        elif len(a) != len(b):
            yield f"{name}.length", len(a), len(b)
        else:
            for k, (one, other) in enumerate(zip(a, b, strict=True)):
                yield from _parts(part.kind.base, one, other, f"{name}[{k}].")


def _fields(kind: str, first: Any, second: Any, path: str) -> Iterator[str]:
    for name, a, b in _parts(kind, first, second, path):
        if isinstance(a, np.ndarray):
            if len(a) != len(b):
                yield f"{name}: {len(a)} and {len(b)} values"
            elif not np.array_equal(a, b, equal_nan=a.dtype.kind == "f"):
                unlike = np.flatnonzero((a != b) & ~(np.isnan(a) & np.isnan(b)) if a.dtype.kind == "f" else a != b)
                k = int(unlike[0])
                yield f"{name}[{k}]: {a[k]!s} and {b[k]!s} ({len(unlike)} of {len(a)} values differ)"
        elif a != b and not (_is_nan(a) and _is_nan(b)):
            at = next((k for k, (x, y) in enumerate(zip(a, b, strict=False)) if x != y), 0) if isinstance(a, str) else 0
            yield f"{name}: {_short(a, at)} and {_short(b, at)}"


def _gaps(kind: str, first: Any, second: Any) -> Iterator[float]:
    for _, a, b in _parts(kind, first, second, ""):
        if isinstance(a, np.ndarray) and a.dtype.kind == "f" and len(a) == len(b) and len(a):
            with np.errstate(invalid="ignore"):  # inf - inf
                gap = np.abs(np.asarray(a, np.float64) - np.asarray(b, np.float64))
            yield float(np.max(gap, where=np.isfinite(gap), initial=0.0))
        elif isinstance(a, float):
            yield abs(a - b)


def _is_nan(value: Any) -> bool:
    return isinstance(value, float) and value != value


def _short(value: Any, at: int) -> str:
    """Return a value as text. Long text is shortened to the part around a position."""
    if isinstance(value, str) and len(value) > SHOWN:
        start = max(at - SHOWN // 2, 0)
        value = ("..." if start else "") + value[start : start + SHOWN] + ("..." if start + SHOWN < len(value) else "")
    return repr(value)


AHEAD_MAX = 100_000  # maximum number of queued messages per channel while one recording is ahead


@dataclass
class Parting:
    """A channel whose messages differ. text: the first difference.

    gaps: (time [s], largest absolute difference) for each pair of messages whose numbers differ.
    """

    topic: str
    tick: int
    text: str
    messages: int = 0
    gaps: list[tuple[float, float]] = field(default_factory=list)


@dataclass
class Comparison:
    """A comparison of two recordings. compared: the number of messages compared.

    partings: sorted by tick, then in recording order. notes: other differences as text, such as the seed.
    """

    compared: int
    partings: list[Parting]
    notes: list[str]

    @property
    def same(self) -> bool:
        """Whether all messages in both recordings are byte-identical."""
        return not self.partings


def diff(first: Recording, second: Recording) -> Comparison:
    """Compare two recordings message by message, pairing the n-th messages of each channel, in recording order."""
    found: dict[str, Parting] = {}
    waiting: dict[str, deque[tuple[int, Recorded]]] = defaultdict(deque)  # of the recording that is ahead (0 or 1)
    compared = 0
    for side, recorded in _in_turn(first, second):
        queue = waiting[recorded.topic]
        if not queue or queue[0][0] == side:
            if len(queue) < AHEAD_MAX:
                queue.append((side, recorded))
            continue
        _, other = queue.popleft()
        pair = (other, recorded) if side else (recorded, other)
        compared += 1
        if pair[0].data != pair[1].data or pair[0].time_ns != pair[1].time_ns:
            _add(found, first, *pair)
    for topic, queue in waiting.items():
        if queue:
            side, recorded = queue[0]
            parting = found.setdefault(topic, Parting(topic, recorded.time_ns // first.step_ns, ""))
            parting.text = parting.text or f"only {(first, second)[side].path} has it: {len(queue)} messages"
            parting.messages += len(queue)
    return Comparison(compared, sorted(found.values(), key=lambda parting: parting.tick), _notes(first, second))


def _in_turn(first: Recording, second: Recording) -> Iterator[tuple[int, Recorded]]:
    """Yield the messages of both recordings in turn, each with the recording's number (0 or 1)."""
    sides = [iter(first.messages()), iter(second.messages())]
    open_sides = {0, 1}
    while open_sides:
        for side in tuple(open_sides):
            recorded = next(sides[side], None)
            if recorded is None:
                open_sides.discard(side)
            else:
                yield side, recorded


def _add(found: dict[str, Parting], recording: Recording, a: Recorded, b: Recorded) -> None:
    parting = found.get(a.topic)
    if parting is None:
        tick = min(a.time_ns, b.time_ns) // recording.step_ns
        parting = found[a.topic] = Parting(a.topic, tick, _text(a, b))
    parting.messages += 1
    if a.type == b.type and a.data != b.data:
        gap = largest(a.type, a.data, b.data)
        if math.isfinite(gap):
            parting.gaps.append((1e-9 * a.time_ns, gap))


def _text(a: Recorded, b: Recorded) -> str:
    if a.type != b.type:
        return f"type {a.type} and {b.type}"
    if a.time_ns != b.time_ns:
        return f"at {1e-9 * a.time_ns:g} s and {1e-9 * b.time_ns:g} s"
    return differences(a.type, a.data, b.data)


def _notes(first: Recording, second: Recording) -> list[str]:
    kinds = {"scenario": "scenario", "seed": "seed", "fingerprint": "scenario's content", "build": "build"}
    notes = [
        f"{what}: {getattr(first.start, key)} and {getattr(second.start, key)}"
        for key, what in kinds.items()
        if getattr(first.start, key) != getattr(second.start, key)
    ]
    return notes + [f"{each.path}: was cut off" for each in (first, second) if not each.complete]
