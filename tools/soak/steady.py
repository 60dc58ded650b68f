"""The memory, processor time and files that a process uses, whether they stay constant, and how a soak test ends."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).parents[1] / "bench"))
from _harness import child, ended, peak_mb, resident_mb, result_of, station_page, trimmed_mb

__all__ = ["child", "ended", "peak_mb", "resident_mb", "result_of", "station_page", "trimmed_mb"]


def open_files() -> int:
    """Return the number of open files except sockets, since the number of clients does not depend on this process."""
    count = 0
    for link in Path("/proc/self/fd").iterdir():
        with suppress(OSError):  # it has been closed in the meantime
            count += not str(link.readlink()).startswith("socket:")
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


def verdict(wrong: Iterable[str]) -> int:
    """Print what broke a rule; return the exit code."""
    found = list(wrong)
    print(f"wrong: {', '.join(found) or 'nothing'}", flush=True)
    return int(bool(found))
