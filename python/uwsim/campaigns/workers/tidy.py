"""Returns the memory of deleted simulators to the system at intervals, so that workers do not keep growing."""

from __future__ import annotations

import ctypes
import gc
from contextlib import suppress
from itertools import count

EVERY = 25
"""The number of jobs between collections. Python frees a simulator's cyclic parts late, and malloc keeps the memory."""
LONG_S = 4.0
"""The time of a job that is worth one by itself."""

_done = count(1)


def tidy_now_and_then(job_s: float = 0.0) -> None:
    """Return memory to the system, which takes about 40 ms, at intervals; call this after each job. job_s: its time."""
    if next(_done) % EVERY == 0 or job_s > LONG_S:
        gc.collect()
        with suppress(OSError, AttributeError):  # if the C library is not glibc
            ctypes.CDLL("libc.so.6").malloc_trim(0)
