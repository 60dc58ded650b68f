"""Returns the memory of deleted simulators to the system at intervals, so that workers do not keep growing."""

from __future__ import annotations

import ctypes
import gc
from contextlib import suppress
from itertools import count

EVERY = 25
"""The number of jobs between collections. Python frees a simulator's cyclic parts late, and malloc keeps the memory."""

_done = count(1)


def tidy_now_and_then() -> None:
    """Return memory at intervals; call this after each job."""
    if next(_done) % EVERY == 0:
        tidy()


def tidy() -> None:
    """Return memory to the system; takes about 40 ms. Call this after a long job."""
    gc.collect()
    with suppress(OSError, AttributeError):  # if the C library is not glibc
        ctypes.CDLL("libc.so.6").malloc_trim(0)
