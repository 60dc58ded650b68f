"""Work as a count, so that a test of how it grows depends on no clock: the lines of uwsim's Python that a call runs."""

import sys
from collections.abc import Callable
from functools import partial
from types import FrameType
from typing import Any


def lines_run(call: Callable[[], object]) -> int:
    """Return how many lines of uwsim's own code a call runs on this thread. Work within C is not counted."""
    count = 0

    def trace(frame: FrameType, event: str, argument: Any) -> Any:
        nonlocal count
        if event == "line":
            count += 1
        return trace if "/uwsim/" in frame.f_code.co_filename else None

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        call()
    finally:
        sys.settrace(before)
    return count


def assert_linear(call: Callable[[Any], object], made: Callable[[int], Any], k: int) -> None:
    """Require that `call`, given what `made` returns for k, 2k and 4k elements, works in proportion to them.

    A tenth more is accepted, and a hundred lines.
    """
    call(made(1))  # imports and caches
    one, two, four = (lines_run(partial(call, made(n))) for n in (k, 2 * k, 4 * k))
    assert two <= 2.2 * one + 100 and four <= 2.2 * two + 100, f"{one}, {two}, {four} lines for {k}, {2 * k}, {4 * k}"
