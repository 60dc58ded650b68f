"""Simulated time for missions: a mission is a generator that yields waits, composed of steps that are also generators.

    def mission(vehicle):
        vehicle.undock()
        yield from dive_to(vehicle, 5.0)
        vehicle.set_effort(surge=0.5)
        yield wait(10.0)
        yield from until(lambda: vehicle.sensors["altitude"].read() < 4.0, timeout_s=60.0)

`parallel` and `race` run several steps at once. Simultaneous events are processed in the order of the arguments.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import Any, TypeVar

from uwsim.navigation.control.protocols import Clock


class StoppedError(Exception):
    """The mission ended early; the message states the reason, such as "stuck 3 m before (10, 20, -5) m"."""


T = TypeVar("T")
LONGEST_S = 1e9


@dataclass(frozen=True)
class Wait:
    """A pause: simulated time advances by its duration when a mission yields it."""

    duration_s: float

    @property
    def duration_ns(self) -> int:
        """The duration in nanoseconds."""
        return round(self.duration_s * 1e9)

    def __iter__(self) -> Generator[Wait, None, None]:
        """Make `yield from wait(1.0)` equivalent to `yield wait(1.0)`."""
        yield self


Steps = Generator[Wait, None, T]
"""A mission, or a part of one, that returns a T."""


def wait(duration_s: float) -> Wait:
    """Return a pause, during which simulated time advances when a mission yields it.

    The simulator rounds it to whole steps, at least one. Raises ValueError unless 1e-9 <= duration_s <= LONGEST_S.
    """
    if not 1e-9 <= duration_s <= LONGEST_S:  # false for NaN as well
        raise ValueError(f"wait: duration_s = {duration_s} s: must be positive and at most {LONGEST_S:g} s")
    return Wait(float(duration_s))


def until(condition: Callable[[], object], *, timeout_s: float = math.inf, every_s: float = 0.1) -> Steps[bool]:
    """Wait until a condition holds, checking it every every_s; return True, or False after timeout_s."""
    pause, waited_s = wait(every_s), 0.0
    while not condition():
        if waited_s >= timeout_s:
            return False
        yield pause
        waited_s += every_s
    return True


def parallel(*branches: Steps[Any]) -> Steps[list[Any]]:
    """Run all branches at once; when all have ended, return their results in order.

    An error in one branch ends the others.
    """
    results = yield from _at_once(branches, len(branches))
    return [results[k] for k in range(len(branches))]


def race(*branches: Steps[Any]) -> Steps[tuple[int, Any]]:
    """Run all branches at once until one ends; return its index and result. The others are closed."""
    if not branches:
        raise ValueError("race: must be given at least one branch")
    results = yield from _at_once(branches, 1)
    return next(iter(results.items()))


def _at_once(branches: tuple[Steps[Any], ...], enough: int) -> Steps[dict[int, Any]]:
    """Run branches, waking each at its own times, until `enough` have ended; return their results by index."""
    now_ns, results = 0, dict[int, Any]()
    agenda = [(now_ns, k) for k in range(len(branches))]  # a heap: at equal times, the first branch goes first
    try:
        while agenda and len(results) < enough:
            wake_ns, k = heapq.heappop(agenda)
            if wake_ns > now_ns:
                yield Wait(1e-9 * (wake_ns - now_ns))
                now_ns = wake_ns
            try:
                pause = checked_wait(next(branches[k]))
            except StopIteration as end:
                results[k] = end.value
            else:
                heapq.heappush(agenda, (now_ns + pause.duration_ns, k))
    finally:
        for branch in branches:
            branch.close()
    return results


def checked_wait(yielded: Any) -> Wait:
    """Return the yielded wait. Raises TypeError, showing the correct form, if a mission yielded something else."""
    if isinstance(yielded, Wait):
        return yielded
    if isinstance(yielded, Generator):
        step = getattr(yielded, "__name__", "step")
        raise TypeError(f"the mission yields a step: write `yield from {step}(...)`")
    raise TypeError(f"the mission yields {yielded!r:.60}: write `yield wait(seconds)`")


def drive(steps: Steps[T], clock: Clock) -> T:
    """Run the steps to their end, advancing the clock by each wait that they yield; return their result."""
    try:
        while True:
            try:
                pause = checked_wait(next(steps))
            except StopIteration as end:
                result: T = end.value
                return result
            clock.wait(pause.duration_s)
    finally:
        steps.close()  # runs the `finally` blocks now, regardless of how it ended
