"""A bag to look at: the beginning of a run of a team's program, with its scans, pictures and frames."""

from __future__ import annotations

import shutil
from pathlib import Path
from tempfile import TemporaryDirectory

from uwsim.base.own_files import require_own
from uwsim.league.referee import Run, fly_run
from uwsim.league.team import load_course, load_team

UNTIL_S = 60.0
SHOWN = (
    "odom", "tf", "tf_static", "robot_description", "scan", "camera/*/image_raw/compressed", "camera/*/camera_info"
)  # fmt: skip
"""Patterns of the topics that Foxglove draws: the pose, the frames, the vehicle, the sonar and the pictures."""


def record_bag(
    folder: str | Path, seed: int, out: str | Path, *, course: str | None = None, until_s: float = UNTIL_S
) -> str:
    """Fly a team's program over the beginning of a course; write an MCAP file, and return what the program lacks.

    course: by default the one in the team's file. until_s: simulated time. Pictures are those of the vehicle, two in a
    second, 320 pixels wide. Raises ScenarioError, ValueError or OSError.
    """
    team, to = load_team(folder), Path(out)
    exercise = load_course(team.course if course is None else course, folder)
    team.require_rate(exercise.made_scenario())
    if to.suffix != ".mcap":
        raise ValueError(f"'{to}': must end in .mcap")
    require_own(to)
    short = exercise.model_copy(update={"time_s": min(exercise.time_s, until_s)})
    with TemporaryDirectory() as scratch:
        run = Run(short, seed, team, Path(folder).resolve(), Path(scratch), topics=SHOWN)
        found = fly_run(run)
        shutil.move(run.file(".mcap"), to)
    return "; ".join(found["why"])
