"""Runs a mission and determines how it ended: on its own, at its time limit, stopped, interrupted, or with an error."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from uwsim.flight.clock import FlightOverError
from uwsim.flight.mission_file import mission_error
from uwsim.flight.record import DONE, INTERRUPTED
from uwsim.missions.stopped import StoppedError


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
