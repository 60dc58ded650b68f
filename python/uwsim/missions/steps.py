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


TOLERANCE_RAD = math.radians(0.5)
HEAD_TIMEOUT_S = 60.0


def is_at(sonar: Any, elevation_rad: float) -> bool:
    """Return whether the head has reached an elevation; always True for a sonar that does not report its elevation."""
    return bool(abs(getattr(sonar, "elevation_rad", elevation_rad) - elevation_rad) <= TOLERANCE_RAD)


def until_at(sonar: Any, elevation_rad: float) -> Steps[bool]:
    """Wait on the spot until the head reaches an elevation; return False on timeout."""
    return until(lambda: is_at(sonar, elevation_rad), timeout_s=HEAD_TIMEOUT_S)


TIMEOUT_S = 120.0
"""Longer than any packaged head needs for half a turn; a slower head needs a longer timeout_s."""


def aim_to(
    head: Any,
    elevation_rad: float | None = None,
    *,
    pan_rad: float | None = None,
    tilt_rad: float | None = None,
    timeout_s: float = TIMEOUT_S,
) -> Steps[None]:
    """Turn a multibeam's head to an elevation, or a camera to pan and tilt, and wait until it points there.

    head: a sonar or camera, such as vehicle.sonar or vehicle.cameras["front"]. elevation_rad: elevation of a sonar,
    positive up. pan_rad: pan of a camera, positive to port. tilt_rad: tilt of a camera, positive down; None leaves an
    axis unchanged. Raises ValueError for angles that the head does not have or cannot reach, and StoppedError if it has
    not arrived after timeout_s.
    """
    if elevation_rad is not None and (pan_rad is not None or tilt_rad is not None):
        raise ValueError("aim_to: either elevation_rad, of a sonar, or pan_rad and tilt_rad, of a camera")
    if elevation_rad is not None:
        head.aim(elevation_rad)
    elif pan_rad is not None or tilt_rad is not None:
        head.aim(pan_rad=pan_rad, tilt_rad=tilt_rad)
    else:
        raise ValueError("aim_to: needs elevation_rad, of a sonar, or pan_rad or tilt_rad, of a camera")
    if not (yield from until(lambda: head.is_aimed, timeout_s=timeout_s)):
        raise StoppedError(f"'{head.name}' has not reached its aim after {timeout_s:g} s")
