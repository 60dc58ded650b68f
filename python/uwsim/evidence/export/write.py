"""Writes a scenario's file for another simulator, and its meshes in a folder beside it."""

from __future__ import annotations

from pathlib import Path

from uwsim.base.atomic_file import write_atomically
from uwsim.base.options import OptionError
from uwsim.base.own_files import require_own
from uwsim.evidence.export.from_scenario import exported
from uwsim.evidence.export.sdf import sdf_files
from uwsim.evidence.export.stonefish import stonefish_files
from uwsim.scenario import load

FORMATS = {".sdf": "Gazebo", ".world": "Gazebo", ".scn": "Stonefish"}


def export(source: str, out: Path) -> list[str]:
    """Write a scenario, by its name or path, for the simulator that `out` names by its suffix.

    Return a line for all that is left out or assumed. Raises OptionError, ScenarioError or OSError; nothing is written
    then.
    """
    simulator = FORMATS.get(out.suffix.lower())
    if simulator is None:
        raise OptionError(f"--out {out}: must end in .sdf, for Gazebo, or .scn, for Stonefish")
    scenario = load(source)
    world, folder = exported(scenario), f"{out.stem}_{out.suffix[1:]}"
    files = sdf_files(world, folder) if simulator == "Gazebo" else stonefish_files(world, folder, scenario)
    paths = {out.parent / folder / name if name else out: content for name, content in files.items()}
    for path in paths:
        require_own(path)
    (out.parent / folder).mkdir(parents=True, exist_ok=True)
    for path in reversed(paths):  # the file that names the others is the last
        write_atomically(path, paths[path])
    return world.found.notes
