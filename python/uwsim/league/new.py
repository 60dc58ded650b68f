"""new_team: writes a team's folder, a ROS 2 workspace whose pilot flies the pool's course."""

from __future__ import annotations

import shutil
from pathlib import Path

from uwsim.league.team import TEAM
from uwsim.scenario.read.assets import assets_folder


def new_team(folder: str | Path) -> list[Path]:
    """Write a team's folder; return its files. Raises FileExistsError for a folder that is not empty, or OSError."""
    to = Path(folder)
    if to.is_symlink() or (to.exists() and (not to.is_dir() or any(to.iterdir()))):
        raise FileExistsError(f"'{to}': must be a new folder, or an empty one")
    source = assets_folder() / "templates" / "team"
    shutil.copytree(source, to, dirs_exist_ok=True, ignore=shutil.ignore_patterns("__pycache__"))
    file = to / TEAM
    name = "".join(c for c in to.resolve().name if c.isalnum() or c in " -_") or "our team"
    file.write_text(file.read_text(encoding="utf-8").replace("our team", f'"{name[:80]}"', 1), encoding="utf-8")
    return sorted(path for path in to.rglob("*") if path.is_file())
