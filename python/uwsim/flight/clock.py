"""The clock of a mission in flight, the autosave of its map, and how the mission ends."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any, NamedTuple

from uwsim.base.stoppable import Stoppable, note_kept, stop_on_signals
from uwsim.base.wall_timer import Measurement
from uwsim.flight.mission_file import mission_error
from uwsim.flight.record import DONE, INTERRUPTED
from uwsim.missions.steps import StoppedError
from uwsim.simulator.simulator import Simulator


class FlightOverError(Exception):
    """Raised to end the flight immediately; the message is the reason."""


class FlightClock:
    """A Clock that steps a simulator.

    Waits are rounded to whole steps, at least one; rounding errors do not accumulate. end_tick: the tick at which the
    flight ends; end_because: the reason to report. on_pause: called after each wait, before the mission continues; may
    raise FlightOverError. physics: measures the wall time of the steps.
    """

    def __init__(
        self, sim: Simulator, end_tick: int, end_because: str, on_pause: Callable[[], None], physics: Measurement
    ) -> None:
        self._sim, self._step_s, self._physics = sim, sim.step_s, physics
        self._end_tick, self.end_because = end_tick, end_because
        self._on_pause = on_pause
        self._start_tick, self._waited_s = sim.tick, 0.0

    @property
    def time_s(self) -> float:
        """Simulated time in seconds."""
        return self._sim.time_s

    def wait(self, duration_s: float) -> None:
        """Let simulated time pass. Raises FlightOverError at the time limit."""
        sim, tick = self._sim, self._sim.tick
        self._waited_s += duration_s
        wake_tick = max(self._start_tick + round(self._waited_s / self._step_s), tick + 1)
        with self._physics:
            sim.step(min(wake_tick, max(self._end_tick, tick)) - tick)
        if sim.tick >= self._end_tick:
            raise FlightOverError(self.end_because)
        self._on_pause()


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


class End(NamedTuple):
    """How a mission ended.

    because: the reason, as a clause. result: the mission's return value. error: the exception that it raised.
    """

    because: str
    result: Any = None
    error: Exception | None = None


def run_to_end(run: Callable[[], Any], file: Path | None, *, foreign: tuple[type[Exception], ...] = ()) -> End:
    """Run a mission; return how it ended.

    file: the mission's file, if any, so that errors can name the line. foreign: exception types not caused by the
    mission.
    """
    try:
        return End(DONE, run())
    except (FlightOverError, StoppedError) as over:
        return End(str(over))
    except KeyboardInterrupt:
        return End(INTERRUPTED)
    except Exception as raised:
        error = raised if file is None or isinstance(raised, foreign) else mission_error(raised, file)
        return End(f"the mission raised {type(raised).__name__}: {error}", error=error)
