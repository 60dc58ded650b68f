"""RareLog: logs each warning at most once a minute, so that no client can fill the log."""

from __future__ import annotations

import time
from collections import Counter
from logging import Logger

EVERY_S = 60.0
KINDS_MAX = 100


class RareLog:
    """Logs a warning's first occurrence immediately. Repeats are counted and reported at most once a minute."""

    def __init__(self, log: Logger) -> None:
        self._log = log
        self._logged_s: dict[str, float] = {}
        self._left_out: Counter[str] = Counter()

    def warning(self, text: str) -> None:
        """Log a warning, or count it."""
        now_s = time.monotonic()
        if text not in self._logged_s and len(self._logged_s) >= KINDS_MAX:
            text = "warnings of further kinds"
        if now_s - self._logged_s.get(text, -EVERY_S) < EVERY_S:
            self._left_out[text] += 1
            return
        self._logged_s[text] = now_s
        count = self._left_out.pop(text, 0)
        self._log.warning("%s%s", text, f" (and {count} times before)" if count else "")
