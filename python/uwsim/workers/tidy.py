"""Gives back the memory of simulators that are gone, now and then, so that a worker does not grow."""

from __future__ import annotations

import ctypes
import gc
from contextlib import suppress
from itertools import count

EVERY = 25
"""Jobs. A simulator's parts know each other, so Python frees them late, and C's allocator keeps their memory later."""

_done = count(1)


def tidy_now_and_then() -> None:
    """Call this after each job."""
    if next(_done) % EVERY == 0:
        tidy()


def tidy() -> None:
    """Give memory back; some 40 ms. Call this after a long job."""
    gc.collect()
    with suppress(OSError, AttributeError):  # where the C library is not glibc
        ctypes.CDLL("libc.so.6").malloc_trim(0)
