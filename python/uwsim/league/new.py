"""new_team: writes a team's folder, a ROS 2 workspace whose pilot flies a course."""

from __future__ import annotations

import shutil
from pathlib import Path

from uwsim.league.team import TEAM
from uwsim.scenario.read.assets import assets_folder

COURSES = ("pool-course", "sea-course")
"""The courses for which there is a pilot; that of the first is in the template itself."""


def new_team(folder: str | Path, course: str = COURSES[0]) -> list[Path]:
    """Write a team's folder, with the pilot of a course; return its files.

    Raises ValueError, FileExistsError for a folder that is not empty, or OSError.
    """
    if course not in COURSES:
        raise ValueError(f"course = '{course}': must be one of {', '.join(COURSES)}")
    to = Path(folder)
    if to.is_symlink() or (to.exists() and (not to.is_dir() or any(to.iterdir()))):
        raise FileExistsError(f"'{to}': must be a new folder, or an empty one")
    templates = assets_folder() / "templates"
    for source in (templates / "team", templates / "courses" / course):  # the second replaces the pilot and its tests
        if source.is_dir():
            shutil.copytree(source, to, dirs_exist_ok=True, ignore=shutil.ignore_patterns("__pycache__"))
    file = to / TEAM
    name = "".join(c for c in to.resolve().name if c.isalnum() or c in " -_") or "our team"
    text = file.read_text(encoding="utf-8").replace("our team", f'"{name[:80]}"', 1)
    file.write_text(text.replace(COURSES[0], course, 1), encoding="utf-8")
    return sorted(path for path in to.rglob("*") if path.is_file())
