"""What a process has in use, and whether that stays the same: for the programs of this folder that run for long."""

from __future__ import annotations

import ctypes
import gc
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np


def resident_mb() -> float:
    """Return this process's memory in RAM, garbage collected."""
    gc.collect()
    return 1e-6 * int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def trimmed_mb() -> float:
    """Return the memory in RAM when the C library has given back what it keeps of freed blocks, which varies."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    return resident_mb()


class _Allocations(ctypes.Structure):
    """The C library's struct mallinfo2; hblkhd are bytes of large blocks, uordblks those of others."""

    _fields_ = tuple(
        (name, ctypes.c_size_t)
        for name in (
            *("arena", "ordblks", "smblks", "hblks", "hblkhd"),
            *("usmblks", "fsmblks", "uordblks", "fordblks", "keepcost"),
        )
    )


def in_use_mb() -> float:
    """Return what is allocated by malloc and not yet freed; the rest of the memory is kept by it for later."""
    library = ctypes.CDLL(None)
    library.mallinfo2.restype = _Allocations
    found = library.mallinfo2()
    return float(1e-6 * (found.uordblks + found.hblkhd))


def peak_mb() -> float:
    """Return the most memory in RAM that this process has ever had."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(1e-3 * 1.024 * int(line.split()[1]) for line in lines if line.startswith("VmHWM"))


def thread_cpu_s() -> dict[int, float]:
    """Return the processor time of each thread, by its number."""
    used = {}
    for folder in Path("/proc/self/task").iterdir():
        try:
            used[int(folder.name)] = 1e-9 * int((folder / "schedstat").read_text().split()[0])
        except OSError:  # has ended meanwhile
            continue
    return used


def open_files() -> int:
    """Return the number of open files, without sockets: how many clients there are is no affair of this process."""
    count = 0
    for link in Path("/proc/self/fd").iterdir():
        try:
            count += not str(link.readlink()).startswith("socket:")
        except OSError:
            continue
    return count


def growth(samples: Sequence[float], settling: float) -> float:
    """Return by how much of itself a straight line through the samples grows, without the first share of them."""
    kept = np.array(samples[int(settling * len(samples)) :])
    slope, begin = np.polyfit(np.arange(len(kept)), kept, 1)
    return float(slope * (len(kept) - 1) / begin)


def drift(samples: Sequence[float], settling: float) -> float:
    """Return by how much the median of the last third differs from that of the first, without the first share."""
    kept = samples[int(settling * len(samples)) :]
    third = max(len(kept) // 3, 1)
    return float(np.median(kept[-third:]) / np.median(kept[:third]) - 1.0)
