"""The reasons for which targets are refused, which stations repeat many times a second."""

from __future__ import annotations

import re
from collections.abc import Callable

AGAIN_S = 10.0
KINDS_MAX = 50
TARGETS = ("SET_POSITION_TARGET_LOCAL_NED", "SET_POSITION_TARGET_GLOBAL_INT", "SET_ATTITUDE_TARGET")
NUMBER = re.compile(r"nan|inf|[-+]?\d[\d.]*(e[-+]?\d+)?")


class Refusals:
    """Passes each reason once, until a target is accepted or 10 s have passed. time_s: returns the simulated time.

    Reasons that differ in their numbers alone are the same.
    """

    def __init__(self, time_s: Callable[[], float]) -> None:
        self._time_s = time_s
        self._said_s: dict[str, float] = {}

    def is_new(self, text: str) -> bool:
        """Return whether a reason is to be sent now, and count it as sent if so."""
        kind, now_s = NUMBER.sub("#", text), self._time_s()
        if 0.0 <= now_s - self._said_s.get(kind, -AGAIN_S) < AGAIN_S:
            return False
        if len(self._said_s) >= KINDS_MAX:
            self._said_s.clear()
        self._said_s[kind] = now_s
        return True

    def accepted(self) -> None:
        """Send every reason again when it occurs."""
        self._said_s.clear()
