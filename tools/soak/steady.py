"""The memory, processor time and files that a process uses, and checks that they stay constant during a soak test."""

from __future__ import annotations

import ctypes
import gc
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np


def resident_mb() -> float:
    """Return this process's resident memory in MB, after a garbage collection."""
    gc.collect()
    return 1e-6 * int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def trimmed_mb() -> float:
    """Return the resident memory in MB after the C library has returned its freed blocks, whose size varies."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    return resident_mb()


class _Allocations(ctypes.Structure):
    """The C library's struct mallinfo2; hblkhd counts the bytes of large blocks, uordblks those of others."""

    _fields_ = tuple(
        (name, ctypes.c_size_t)
        for name in (
            *("arena", "ordblks", "smblks", "hblks", "hblkhd"),
            *("usmblks", "fsmblks", "uordblks", "fordblks", "keepcost"),
        )
    )


def in_use_mb() -> float:
    """Return the memory that malloc has allocated and not yet freed; the rest of its memory is kept for reuse."""
    library = ctypes.CDLL(None)
    library.mallinfo2.restype = _Allocations
    found = library.mallinfo2()
    return float(1e-6 * (found.uordblks + found.hblkhd))


def peak_mb() -> float:
    """Return this process's peak resident memory in MB."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(1e-3 * 1.024 * int(line.split()[1]) for line in lines if line.startswith("VmHWM"))


def thread_cpu_s() -> dict[int, float]:
    """Return the CPU time of each thread, by thread id."""
    used = {}
    for folder in Path("/proc/self/task").iterdir():
        try:
            used[int(folder.name)] = 1e-9 * int((folder / "schedstat").read_text().split()[0])
        except OSError:  # the thread has ended in the meantime
            continue
    return used


def open_files() -> int:
    """Return the number of open files except sockets, since the number of clients does not depend on this process."""
    count = 0
    for link in Path("/proc/self/fd").iterdir():
        try:
            count += not str(link.readlink()).startswith("socket:")
        except OSError:
            continue
    return count


def growth(samples: Sequence[float], settling: float) -> float:
    """Return the relative growth of a straight line through the samples, ignoring the first share of them."""
    kept = np.array(samples[int(settling * len(samples)) :])
    slope, begin = np.polyfit(np.arange(len(kept)), kept, 1)
    return float(slope * (len(kept) - 1) / begin)


def drift(samples: Sequence[float], settling: float) -> float:
    """Return the relative difference between the medians of the last and first thirds, ignoring the first share."""
    kept = samples[int(settling * len(samples)) :]
    third = max(len(kept) // 3, 1)
    return float(np.median(kept[-third:]) / np.median(kept[:third]) - 1.0)
