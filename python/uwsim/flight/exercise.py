"""fly_exercise: a mission flies an exercise as its pilot, headless; the score sheet is written next to the results."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from uwsim.exercises import Course, Exercise, load_exercise
from uwsim.exercises.sheet import write_sheet
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
    threads: int | None = None,
    screen: Silent | None = None,
    **options: Any,
) -> FlownExercise:
    """Fly a mission as the pilot of an exercise, and judge it against the truth.

    exercise: a packaged name, a path or an Exercise. mission: see uwsim.fly. out: folder for sheet.html, score.json and
    the flight's files. options: other arguments of uwsim.fly, such as `function`, `estimate` or `record`. The flight
    ends when the mission does, or when the exercise's time is up. Raises ValueError, ScenarioError or OSError.
    """
    found = exercise if isinstance(exercise, Exercise) else load_exercise(exercise)
    sim = Simulator(found.made_scenario(), threads=threads)
    Course.require_events(found, sim)
    course = Course(found, sim).attach()
    options.setdefault("report", "json")
    try:
        record = fly(mission, sim, out, time_limit_s=found.time_s, screen=screen, **options)
        course.judge()
    finally:
        course.detach()
    course.finish(f"the pilot ended: {record.ended_because}")
    if out is not None:
        write_sheet(Path(out), course)
    return FlownExercise(course, record)
