"""Saves a survey as it is flown, so that nothing but the last interval can be lost."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

from uwsim.mapping import OccupancyMap
from uwsim.survey.checkpoint import Checkpoint, SurveyOrder
from uwsim.survey.flight_state import FlightState

MOST_OF_THE_TIME = 0.5  # that saving may take, where a save takes longer than the interval


class Autosave:
    """Watches a flight: saves it every interval_s of wall time, 0 for never; ends it when `stop` was called.

    The first save is at the start, so that there is a map from then on. What cannot be written an interval later is
    told once, and again when it can be; the flight goes on with the map in memory.
    """

    def __init__(
        self, checkpoint: Checkpoint, order: SurveyOrder, interval_s: float, tell: Callable[[str], None]
    ) -> None:
        self._checkpoint = checkpoint
        self._order = order
        self._interval_s = interval_s
        self._tell = tell
        self._due_s = time.monotonic()  # when the last save was asked for
        self._next_s = self._due_s
        self._saves = 0
        self._told = False
        self._stopping = False
        self.failure: str | None = None
        """Why the last save failed."""

    def stop(self) -> None:
        """End the flight at its next pause. May be called by a signal handler."""
        self._stopping = True

    def stopping(self) -> bool:
        """Whether stop was called."""
        return self._stopping

    def save_due(self) -> bool:
        """Whether the interval is over; if so, not again before it was saved."""
        due = self._interval_s > 0.0 and time.monotonic() >= self._next_s
        if due:
            self._due_s, self._next_s = time.monotonic(), math.inf
        return due

    def save(self, state: FlightState, occupancy: OccupancyMap, reference: OccupancyMap | None) -> None:
        """Save, or tell why not."""
        if self._interval_s <= 0.0:
            return
        try:
            self._checkpoint.write(self._order, state, occupancy, reference)
        except (OSError, MemoryError) as error:
            self.failure = str(error)
            if self._saves > 0 and not self._told:  # a short survey only tells how it ends
                self._tell(f"autosave failed: {error}; flying on with the map in memory")
                self._told = True
        else:
            self.failure = None
            if self._told:
                self._tell("autosave works again")
                self._told = False
        self._saves += 1
        took_s = time.monotonic() - self._due_s
        # What is readable must not grow older than the interval while the next is being written.
        self._next_s = self._due_s + max(self._interval_s - took_s, took_s / MOST_OF_THE_TIME)
