"""Finds where two recordings diverge: the first tick and channel that differ, the difference, and later differences."""

from __future__ import annotations

import math
from collections import defaultdict, deque
from collections.abc import Iterator
from dataclasses import dataclass, field

from uwsim.recording.difference import differences, largest
from uwsim.recording.messages import Recorded
from uwsim.recording.reader import Recording

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
