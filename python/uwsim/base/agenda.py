"""Agenda: schedules everything that acts in simulated time, in a fixed order.

The order at tick T is as follows. Reproducibility depends on it, so it is defined only here and checked by
tests/python/base/test_agenda.py.

| when           | rank       | what acts                                              | among themselves     |
|----------------|------------|--------------------------------------------------------|----------------------|
| T is reached   | `OBSERVER` | recorders, samplers, mappers and navigation observe    | as attached          |
|                | `FRAME`    | readings of time and transforms, which others refer to | as subscribed        |
|                | `READING`  | other readings of `LiveSimulator.every`                | as subscribed        |
|                | `DELIVERY` | links deliver arrived messages and send due ones       | arrivals first       |
|                | `REPLAY`   | a replayed recording issues its commands               | as recorded          |
| the clock rests|            | commands of missions, programs and other threads       | as issued            |
| T is left      | `FAULT`    | faults begin, end and grow                             | as declared          |
|                | `HOLD`     | holds steer alongside the stick                        | as engaged           |
|                | `FAILSAFE` | failsafes check and steer                              | in vehicle order     |
|                |            | one native step to T + 1 (`Simulation::step_once`, C++)|                      |

Hence observers never see a command issued at their own tick, failsafes see all of them, and nothing depends on how many
steps a call makes.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator
from enum import IntEnum
from typing import NamedTuple, Protocol

NEVER = 2**62  # later than any tick in practice


class Rank(IntEnum):
    """The order of items that are due at the same tick."""

    OBSERVER = 0
    FRAME = 1
    READING = 2
    DELIVERY = 3
    REPLAY = 4
    FAULT = 5
    HOLD = 6
    FAILSAFE = 7


REACHED = (Rank.OBSERVER, Rank.FRAME, Rank.READING, Rank.DELIVERY, Rank.REPLAY)
LEFT = (Rank.FAULT, Rank.HOLD, Rank.FAILSAFE)


class Due(Protocol):
    """An item that decides at which ticks it acts."""

    @property
    def due_tick(self) -> int:
        """The next tick at which the item acts. It must increase each time the item acts."""


class _Entry(NamedTuple):
    rank: Rank
    item: Due
    act: Callable[[int], object]
    jump: Callable[[int], object]


class Agenda:
    """The agenda of one simulation.

    Items may be added and removed on any thread, but they act on the stepping thread.
    """

    def __init__(self, tick: Callable[[], int]) -> None:
        """tick: returns the simulation's current tick."""
        self._tick = tick
        self._lock = threading.Lock()
        self._keep(())

    def _keep(self, entries: Iterable[_Entry]) -> None:
        self._entries = tuple(sorted(entries, key=lambda one: one.rank))  # stable: in order of addition within a rank
        self._reached = tuple(one for one in self._entries if one.rank in REACHED)
        self._left = tuple(one for one in self._entries if one.rank in LEFT)
        self._of: dict[tuple[Rank, ...], tuple[_Entry, ...]] = {}
        self.is_empty = not self._entries

    def add(
        self,
        item: Due,
        rank: Rank,
        act: Callable[[int], object],
        *,
        jump: Callable[[int], object] = lambda tick: None,
    ) -> None:
        """Schedule an item: act(tick) is called when it is due, after items of its rank that were added earlier.

        An overdue item acts after the next step. jump: called with the new tick when a reset or a restored state has
        changed the time.
        """
        with self._lock:
            self._keep((*self._entries, _Entry(rank, item, act, jump)))

    def remove(self, item: object) -> None:
        """Remove an item, if present."""
        with self._lock:
            self._keep(one for one in self._entries if one.item is not item)

    def clear(self, *ranks: Rank) -> None:
        """Remove all items of these ranks."""
        with self._lock:
            self._keep(one for one in self._entries if one.rank not in ranks)

    def __contains__(self, item: object) -> bool:
        return any(one.item is item for one in self._entries)

    def of(self, *ranks: Rank) -> tuple[_Entry, ...]:
        """Return the entries of these ranks, in order."""
        found = self._of
        if ranks not in found:
            found[ranks] = tuple(one for one in self._entries if one.rank in ranks)
        return found[ranks]

    @property
    def tick(self) -> int:
        """The current tick."""
        return self._tick()

    @property
    def due_tick(self) -> int:
        """The next tick at which something is due."""
        return due_tick(self._entries)

    def parts(self, steps: int) -> Iterator[int]:
        """Split `steps` at ticks where items act: run the items that are due, then yield the steps until the next.

        The split ends early if the simulation is not at the expected tick after a part, because its steps failed or an
        item reset or restored the simulation.
        """
        tick = self._tick()
        end = tick + steps
        while tick < end:
            act(self._left, tick)
            part_end = min(end, max(tick + 1, self.due_tick))
            yield part_end - tick
            tick = part_end
            if self._tick() != tick or (act(self._reached, tick) and self._tick() != tick):
                return

    def jump(self) -> None:
        """Notify all items that a reset or a restored state has changed the time."""
        tick = self._tick()
        for one in self._entries:
            one.jump(tick)


def due_tick(entries: Iterable[_Entry]) -> int:
    """Return the next tick at which any of the entries is due."""
    soonest = NEVER
    for one in entries:
        if (tick := one.item.due_tick) < soonest:
            soonest = tick
    return soonest


def act(entries: Iterable[_Entry], tick: int) -> bool:
    """Run the entries that are due, in order. Return whether there were any."""
    acted = False
    for one in entries:
        if one.item.due_tick <= tick:
            one.act(tick)
            acted = True
    return acted


def next_tick(tick: int, period_ns: int, step_ns: int) -> int:
    """Return the first tick at or after the next multiple of a period after `tick`."""
    periods = tick * step_ns // period_ns + 1
    return -(-periods * period_ns // step_ns)
