"""The referee: one run of a team's program over a course, in a world of the referee's, whose time waits for it."""

from __future__ import annotations

import time
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from uwsim.base.own_files import remove_own_file
from uwsim.channels import Table
from uwsim.channels.delivery.pictures import Stream
from uwsim.exercises import Course, Exercise
from uwsim.exercises.certified import certified_sheet
from uwsim.exercises.course import PERIOD_S
from uwsim.exercises.flyable import flyable
from uwsim.league.cockpit import Cockpit, outside_cameras
from uwsim.league.program import Program, ProgramError
from uwsim.league.team import Team
from uwsim.live import LiveSimulator
from uwsim.recording.recorder import Recorder

SIGHT = ("camera/", "scan", "ping", "points", "forward_looking", "scanning", "laserPointCloud", "proximity", "sonar")
"""Beginnings of the topics that show where things are."""
SMALL = Stream(rate_hz=2.0, width=320)
"""Pictures in a recording."""


@dataclass(frozen=True)
class Run:
    """A run to be flown. folder: the team's. out: receives the recording and the log.

    user: see Program. topics: what is recorded.
    """

    exercise: Exercise
    seed: int
    team: Team
    folder: Path
    out: Path
    user: str | None = None
    threads: int | None = 1
    topics: tuple[str, ...] = ("odom",)

    def file(self, suffix: str) -> Path:
        """Return the path of one of its files."""
        return self.out / f"seed-{self.seed}{suffix}"


def fly_run(run: Run) -> dict[str, Any]:
    """Fly a run; return its certified sheet, why points are missing and the wall time.

    Raises OSError and MemoryError, which may be transient.
    """
    begun_s = time.perf_counter()
    exercise, sim = flyable(run.exercise.model_copy(update={"seed": run.seed}), run.threads)
    recording = run.file(".mcap")
    remove_own_file(recording)
    with ExitStack() as stack:
        live = stack.enter_context(LiveSimulator(sim, speed="max", paused=True))
        command = live.privileged()(lambda name, arguments: live.command(name, **arguments))
        course = Course(exercise, sim, command, outsider=Cockpit.peer, aids=lambda: {"program"})
        stack.callback(course.detach)
        table = Table(sim)
        for name in sim.rov.cameras:
            table.pictures.set_stream(table.sources[0].topic(name), SMALL)
        hidden = ["*/depth/*", *(f"camera/{name}/*" for name in outside_cameras(sim))]
        recorder = Recorder(live, recording, topics=run.topics, without=hidden, shared=table).start()
        stack.callback(recorder.close)
        live.every(PERIOD_S, lambda sim: None, lambda nothing: course.judge())
        door = stack.enter_context(Cockpit(live, exercise, run.team.pictures_hz))
        program = stack.enter_context(Program(run.team.program, run.folder, run.file(".log"), run.user))
        try:
            _converse(program, door, live, course, run.team.period_s)
        except ProgramError as error:
            course.finish(str(error))
        sheet = certified_sheet(course, script=run.folder.name)
        why = reasons(sheet, door)
    return {"sheet": sheet, "why": why, "run_wall_s": time.perf_counter() - begun_s, "error": None}


def _converse(program: Program, door: Cockpit, live: LiveSimulator, course: Course, period_s: float) -> None:
    """Let the program and the simulator take turns until the course is over. Raises ProgramError."""
    names = program.receive().get("reads", [])
    door.read_topics(names if isinstance(names, list) else [names])
    steps = max(round(period_s / live.simulator.step_s), 1)
    _step(live, steps)  # so that the first readings have been taken
    while not course.is_over:
        program.send({"time_s": 1e-9 * live.time_ns, **door.look()})
        door.obey(program.receive().get("commands", []))
        _step(live, steps)
    program.send({"ended_because": course.state()["ended_because"]})


def _step(live: LiveSimulator, steps: int) -> None:
    with live.privileged():
        live.step(steps)
    if live.error is not None:
        raise ProgramError(f"the simulation stopped: {live.error}")


def reasons(sheet: Mapping[str, Any], door: Cockpit) -> list[str]:
    """Return why points are missing, as far as the referee has seen it."""
    found = [f"{reason} ({count} times)" for reason, count in door.complaints.items()]
    if not door.commands:
        found.append("the program has not commanded the vehicle once")
    if not any(name.startswith(SIGHT) for name in door.messages):
        found.append(
            "the program is blind: it reads no camera and no sonar, and where things stand differs with the seed"
        )
    missed = [goal["title"] for goal in sheet["goals"] if goal["share"] < 1.0]
    found += [f"not met: {title}" for title in missed]
    found += [f"{limit['title']}: broken {limit['broken']} times" for limit in sheet["limits"] if limit["broken"]]
    return [*found, f"it ended since {sheet['ended_because']}"] if missed else found
