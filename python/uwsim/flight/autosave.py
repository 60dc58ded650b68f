"""When a flight is saved, and whether it has been asked to stop."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext

from uwsim.stoppable import Stoppable, stop_on_signals

MAX_SHARE_OF_TIME = 0.5  # largest share of the wall time for saving, where a save takes longer than the interval


class FlightAutosave(Stoppable):
    """Saves a flight every interval_s of wall time, 0 for never.

    A save that fails is told through `report`, once; the flight goes on. hears_signals: whether Ctrl-C and SIGTERM end
    it.
    """

    def __init__(
        self, interval_s: float, report: Callable[[str], None] = lambda text: None, *, hears_signals: bool = False
    ) -> None:
        if not 0.0 <= interval_s < math.inf:
            raise ValueError(f"autosave_s = {interval_s} s: must be 0 (never) or more")
        self._interval_s, self._report, self._hears_signals = interval_s, report, hears_signals
        self._next_s = time.monotonic() + interval_s
        self._reported = False

    def flying(self) -> AbstractContextManager[None]:
        """Hear signals during the block, if they are to be heard."""
        return stop_on_signals(self) if self._hears_signals else nullcontext()

    def due(self) -> bool:
        """Whether a save is due; after True, False until it is done."""
        is_due = self._interval_s > 0.0 and time.monotonic() >= self._next_s
        if is_due:
            self._next_s = math.inf
        return is_due

    def save(self, write: Callable[[], None]) -> None:
        """Save by `write`."""
        began_s = time.monotonic()
        try:
            write()
        except (OSError, MemoryError) as error:
            if not self._reported:
                self._report(f"autosave failed: {error}; the flight continues")
            self._reported = True
        else:
            self._reported = False
        now_s = time.monotonic()
        self._next_s = now_s + max(self._interval_s, (now_s - began_s) / MAX_SHARE_OF_TIME)
