"""Decides when a flight's map is saved, and whether a signal has asked it to stop."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext

from uwsim.base.stoppable import Stoppable, note_kept, stop_on_signals

AUTOSAVE_S = 30.0
MAX_SHARE_OF_TIME = 0.5  # largest share of wall time spent on saving, if a save takes longer than the interval


class FlightAutosave(Stoppable):
    """Schedules a save every interval_s seconds of wall time; 0 disables saving.

    The first save is at the start, so that there is always a map. The first failed save is reported through `report`,
    and so is the next successful one; the flight continues in between. handles_signals: whether Ctrl-C and SIGTERM end
    the flight.
    """

    def __init__(
        self, interval_s: float, report: Callable[[str], None] = lambda text: None, *, handles_signals: bool = False
    ) -> None:
        if not 0.0 <= interval_s < math.inf:
            raise ValueError(f"autosave_s = {interval_s} s: must be 0 (never) or more")
        self._interval_s, self._report, self._handles_signals = interval_s, report, handles_signals
        self._started_s = self._next_s = time.monotonic()
        self._saves = 0
        self._reported = False
        self.failure: str | None = None
        """Why the last save failed; None if it succeeded."""

    @property
    def is_on(self) -> bool:
        """Whether the map is saved at all."""
        return self._interval_s > 0.0

    def flying(self) -> AbstractContextManager[None]:
        """Let signals stop the flight during the block, if enabled."""
        return stop_on_signals(self) if self._handles_signals else nullcontext()

    def due(self) -> bool:
        """Return whether a save is due; once this has returned True, it returns False until that save is done."""
        is_due = self.is_on and time.monotonic() >= self._next_s
        if is_due:
            self._started_s, self._next_s = time.monotonic(), math.inf
        return is_due

    def save(self, write: Callable[[], None]) -> None:
        """Save by calling `write`; a failure is reported, not raised."""
        try:
            write()
        except (OSError, MemoryError) as error:
            self.failure = str(error)
            if self._saves > 0 and not self._reported:  # the first failure is reported at the end
                self._report(f"autosave failed: {error}; the flight continues with the map in memory")
                self._reported = True
        else:
            self.failure = None
            if self._handles_signals:
                note_kept("the map is kept as last saved")
            if self._reported:
                self._report("autosave works again")
                self._reported = False
        self._saves += 1
        took_s = time.monotonic() - self._started_s
        # The next save starts early enough to finish before this one is older than the interval.
        self._next_s = self._started_s + max(self._interval_s - took_s, took_s / MAX_SHARE_OF_TIME)
