"""Pacer: keeps the simulated time of a recording in pace with the wall clock."""

from __future__ import annotations

import time
from typing import Literal


class Pacer:
    """Waits until a simulated time is due.

    The schedule starts with the first call and after simulated time goes back.
    """

    def __init__(self, speed: float | Literal["max"]) -> None:
        """speed: simulated seconds per wall-clock second, or "max". Raises ValueError."""
        if speed != "max" and not 1e-3 <= speed <= 1e6:  # false for NaN as well
            raise ValueError(f"speed = {speed:g}: must be in [0.001, 1000000], or max")
        self._speed = speed
        self._zero_s = 0.0
        self._last_ns: int | None = None

    def wait(self, time_ns: int) -> None:
        """Wait until the given simulated time is due."""
        if self._speed == "max":
            return
        due_s = 1e-9 * time_ns / self._speed
        if self._last_ns is None or time_ns < self._last_ns:
            self._zero_s = time.monotonic() - due_s
        self._last_ns = time_ns
        time.sleep(max(self._zero_s + due_s - time.monotonic(), 0.0))
