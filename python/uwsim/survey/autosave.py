"""Saves a survey at intervals while it flies, so that a crash loses at most the last interval."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from uwsim.mapping import OccupancyMap
from uwsim.stoppable import Stoppable
from uwsim.survey.checkpoint import Checkpoint
from uwsim.survey.flight_state import FlightState
from uwsim.survey.request import SurveyRequest

MAX_SHARE_OF_TIME = 0.5  # largest share of the wall time for saving, where a save takes longer than the interval


class Autosave(Stoppable):
    """Supervises a flight: saves it every interval_s of wall time, 0 for never, and ends it after `stop` was called.

    The first save is at the start, so that there is always a map. A save that fails is reported once, through
    `report`, and so is the next that succeeds; meanwhile the flight continues with the map in memory.
    """

    def __init__(
        self, checkpoint: Checkpoint, request: SurveyRequest, interval_s: float, report: Callable[[str], None]
    ) -> None:
        self._checkpoint = checkpoint
        self._request = request
        self._interval_s = interval_s
        self._report = report
        self._started_s = time.monotonic()  # start of the last save
        self._next_s = self._started_s
        self._saves = 0
        self._reported = False
        self.failure: str | None = None
        """Why the last save failed; None if it succeeded."""

    def save_due(self) -> bool:
        """Whether a save is due; after True, False until that save is done."""
        due = self._interval_s > 0.0 and time.monotonic() >= self._next_s
        if due:
            self._started_s, self._next_s = time.monotonic(), math.inf
        return due

    def save(self, state: FlightState, occupancy: OccupancyMap, reference: OccupancyMap | None) -> None:
        """Save the flight; a failure is reported, not raised."""
        if self._interval_s <= 0.0:
            return
        try:
            self._checkpoint.write(self._request, state, occupancy, reference)
        except (OSError, MemoryError) as error:
            self.failure = str(error)
            if self._saves > 0 and not self._reported:  # a survey that ends before its second save reports the end only
                self._report(f"autosave failed: {error}; the flight continues with the map in memory")
                self._reported = True
        else:
            self.failure = None
            if self._reported:
                self._report("autosave works again")
                self._reported = False
        self._saves += 1
        took_s = time.monotonic() - self._started_s
        # The saved survey must not be older than the interval when the next one replaces it.
        self._next_s = self._started_s + max(self._interval_s - took_s, took_s / MAX_SHARE_OF_TIME)
