"""fly_exercise: a mission flies an exercise as its pilot, headless; the score sheet is written next to the results."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from uwsim.base.agenda import NEVER, Rank
from uwsim.exercises import Course, Exercise, load_exercise
from uwsim.exercises.certified import certified_sheet, checked_person
from uwsim.exercises.flyable import flyable
from uwsim.exercises.sheet import remove_stale_sheet, require_room, write_sheet
from uwsim.flight.fly import fly
from uwsim.flight.missions import AnyMission
from uwsim.flight.record import FlightRecord
from uwsim.flight.terminal import Silent
from uwsim.simulator.simulator import Simulator


class FlownExercise(NamedTuple):
    """A judged flight. course: the course, with score and sheet. record: the mission's flight record."""

    course: Course
    record: FlightRecord


def fly_exercise(
    exercise: str | Path | Exercise,
    mission: AnyMission,
    out: str | Path | None = None,
    *,
    person: str = "",
    threads: int | None = None,
    screen: Silent | None = None,
    **options: Any,
) -> FlownExercise:
    """Fly a mission as the pilot of an exercise, and judge it against the truth.

    exercise: a packaged name, a path or an Exercise. mission: see uwsim.fly. out: folder for sheet.html, score.json and
    the flight's files. person: on the sheet. options: other arguments of uwsim.fly, such as `function`, `estimate` or
    `record`. The flight ends when the mission does, or when the exercise's time is up. If the mission fails, its error
    is raised once the sheet has been written. Raises ValueError, ScenarioError or OSError.
    """
    read = exercise if isinstance(exercise, Exercise) else load_exercise(exercise)
    if read.lag_s:
        raise ValueError(f"lag_s = {read.lag_s:g} s: must be 0 for a mission, which is aboard; a person flies with it")
    person = checked_person(person) if person else ""
    if out is not None:
        require_room(Path(out))
    found, sim = flyable(read, threads)
    script = mission_title(mission, options)
    course, begun_tick = Course(found, sim).attach(), sim.tick
    if out is not None:
        _StaleSheet(Path(out), sim)
    options.setdefault("report", "json")
    try:
        record = fly(mission, sim, out, time_limit_s=found.time_s, screen=screen, **options)
        course.judge()
    except Exception as error:
        if sim.tick > begun_tick:
            course.finish(f"the pilot failed: {error}")
            _write(out, course, person, script)
        raise
    finally:
        course.detach()
    course.finish(f"the pilot ended: {record.ended_because}")
    _write(out, course, person, script)
    return FlownExercise(course, record)


def mission_title(mission: AnyMission, options: Mapping[str, Any]) -> str:
    """Return the name of a mission for the sheet: its file's or its function's."""
    function = options.get("function")
    if isinstance(mission, str | Path):
        return f"{Path(mission).name}{f':{function}' if function else ''}"
    return str(getattr(mission, "__name__", type(mission).__name__))


def _write(out: str | Path | None, course: Course, person: str, script: str) -> None:
    if out is not None:
        write_sheet(Path(out), course, certified_sheet(course, person, script=script))


class _StaleSheet:
    """An earlier flight's sheet, which goes when this flight begins, but stays if the call is refused before that."""

    def __init__(self, out: Path, sim: Simulator) -> None:
        self.due_tick, self._out = sim.tick, out
        sim.agenda.add(self, Rank.OBSERVER, self._remove)

    def _remove(self, tick: int) -> None:
        self.due_tick = NEVER
        remove_stale_sheet(self._out)
