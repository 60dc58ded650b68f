"""Agenda: what is due in simulated time, and in which order.

This is the order at tick T. "Same in, same out" rests on it, so it is written here once, and held by
tests/python/base/test_agenda.py.

| when           | rank       | what acts                                              | among themselves     |
|----------------|------------|--------------------------------------------------------|----------------------|
| T is reached   | `OBSERVER` | recorders, samplers, mappers, navigation: look         | as attached          |
|                | `READING`  | `LiveSimulator.every`: a reading goes to its sink      | as subscribed        |
|                | `DELIVERY` | a link: gives what has arrived, sends what is due      | arrivals first       |
| the clock rests|            | commands: of a mission, a program, other threads       | as given             |
| T is left      | `FAULT`    | faults begin, end and grow                             | as declared          |
|                | `FAILSAFE` | failsafes look and steer                               | as their vehicles    |
|                |            | one native step to T + 1 (`Simulation::step_once`, C++)|                      |

Hence observers never see a command of their own tick, a failsafe sees all of them, and nothing depends on how many
steps are made at once.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator
from enum import IntEnum
from typing import NamedTuple, Protocol

NEVER = 2**62  # a tick that never comes


class Rank(IntEnum):
    """The order of what is due at one tick."""

    OBSERVER = 0
    READING = 1
    DELIVERY = 2
    FAULT = 3
    FAILSAFE = 4


REACHED = (Rank.OBSERVER, Rank.READING, Rank.DELIVERY)
LEFT = (Rank.FAULT, Rank.FAILSAFE)


class Due(Protocol):
    """Something that acts at ticks of its own choosing."""

    @property
    def due_tick(self) -> int:
        """The tick at which it acts next; later, once it has acted."""


class _Entry(NamedTuple):
    rank: Rank
    item: Due
    act: Callable[[int], object]
    jump: Callable[[int], object]


class Agenda:
    """The agenda of one simulation. Any thread may add and remove items; the stepping thread does the rest."""

    def __init__(self, tick: Callable[[], int]) -> None:
        """tick: returns the simulation's present tick."""
        self._tick = tick
        self._lock = threading.Lock()
        self._keep(())

    def _keep(self, entries: Iterable[_Entry]) -> None:
        self._entries = tuple(sorted(entries, key=lambda one: one.rank))  # stable: as added within a rank
        self._reached = tuple(one for one in self._entries if one.rank in REACHED)
        self._left = tuple(one for one in self._entries if one.rank in LEFT)
        self.is_empty = not self._entries

    def add(
        self,
        item: Due,
        rank: Rank,
        act: Callable[[int], object],
        *,
        jump: Callable[[int], object] = lambda tick: None,
    ) -> None:
        """Call act(tick) when the item is due, after the others of its rank; an overdue item acts after the next step.

        jump: called with the new tick when a reset or a restored state has changed the time.
        """
        with self._lock:
            self._keep((*self._entries, _Entry(rank, item, act, jump)))

    def remove(self, item: object) -> None:
        """Forget an item, if it is there."""
        with self._lock:
            self._keep(one for one in self._entries if one.item is not item)

    def clear(self, *ranks: Rank) -> None:
        """Forget all items of some ranks."""
        with self._lock:
            self._keep(one for one in self._entries if one.rank not in ranks)

    def __contains__(self, item: object) -> bool:
        return any(one.item is item for one in self._entries)

    def of(self, *ranks: Rank) -> tuple[_Entry, ...]:
        """Return the entries of some ranks, in their order."""
        return tuple(one for one in self._entries if one.rank in ranks)

    @property
    def tick(self) -> int:
        """The present tick."""
        return self._tick()

    @property
    def due_tick(self) -> int:
        """The next tick at which something is due."""
        return due_tick(self._entries)

    def parts(self, steps: int) -> Iterator[int]:
        """Yield the number of steps from each tick at which something acts to the next, and let it act.

        Ends early if the time is not what it should be after the steps: they failed, or an item reset or restored the
        simulation.
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
    """Return the next tick at which one of these is due."""
    soonest = NEVER
    for one in entries:
        if (tick := one.item.due_tick) < soonest:
            soonest = tick
    return soonest


def act(entries: Iterable[_Entry], tick: int) -> bool:
    """Let the due entries act, in order; return whether there was one."""
    acted = False
    for one in entries:
        if one.item.due_tick <= tick:
            one.act(tick)
            acted = True
    return acted


def next_tick(tick: int, period_ns: int, step_ns: int) -> int:
    """Return the first tick after `tick` that is at or after a multiple of a period."""
    periods = tick * step_ns // period_ns + 1
    return -(-periods * period_ns // step_ns)
