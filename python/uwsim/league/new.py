"""new_team: writes a team's folder, a ROS 2 workspace whose pilot flies a course."""

from __future__ import annotations

import shutil
from pathlib import Path

from uwsim.base.named import did_you_mean
from uwsim.league.team import TEAM
from uwsim.scenario.read.assets import assets_folder

POOL = "pool-course"
"""The course of the template. The pilots of others, and their tests, take the place of its own."""


def new_team(folder: str | Path, course: str = POOL) -> list[Path]:
    """Write a team's folder; return its files.

    course: the packaged exercise that its pilot flies. Raises FileExistsError for a folder that is not empty,
    ValueError for a course without a pilot of ours, or OSError.
    """
    to, pilots = Path(folder), assets_folder() / "templates" / "pilots"
    known = [POOL, *sorted(path.stem for path in pilots.glob("*-course.py"))]
    if course not in known:
        raise ValueError(f"course '{course}': must be one of {', '.join(known)}{did_you_mean(course, known)}")
    if to.is_symlink() or (to.exists() and (not to.is_dir() or any(to.iterdir()))):
        raise FileExistsError(f"'{to}': must be a new folder, or an empty one")
    source = assets_folder() / "templates" / "team"
    shutil.copytree(source, to, dirs_exist_ok=True, ignore=shutil.ignore_patterns("__pycache__"))
    name = "".join(c for c in to.resolve().name if c.isalnum() or c in " -_") or "our team"
    for file in (to / TEAM, to / "src/pilot/launch/course.launch.py"):
        text = file.read_text(encoding="utf-8").replace("our team", f'"{name[:80]}"', 1).replace(POOL, course, 1)
        file.write_text(text, encoding="utf-8")
    if course != POOL:
        shutil.copyfile(pilots / f"{course}.py", to / "src/pilot/pilot/pilot.py")
        shutil.copyfile(pilots / "test_pilot.py", to / "src/pilot/test/test_pilot.py")
    return sorted(path for path in to.rglob("*") if path.is_file())
