"""Writes a scenario's file for another simulator, and its meshes in a folder beside it."""

from __future__ import annotations

from pathlib import Path

from uwsim.base.atomic_file import write_atomically
from uwsim.base.options import OptionError
from uwsim.base.own_files import require_own
from uwsim.evidence.export.from_scenario import exported
from uwsim.evidence.export.sdf import sdf_files
from uwsim.evidence.export.stonefish import stonefish_files
from uwsim.scenario import Scenario, exports, load


def write_export(source: str, out: Path) -> list[str]:
    """Write a scenario, by its name or path, for the simulator that `out` names by its suffix.

    Return a line for all that is left out or assumed. Raises OptionError, ScenarioError or OSError; nothing is written
    then.
    """
    suffix = out.suffix[1:]
    try:
        exports.require_known(suffix)
    except ValueError as error:
        raise OptionError(f"--out {out}: {error}") from None
    made = exports.export(load(source), out.stem, suffix)
    paths = {out.parent / name: content for name, content in made.files.items()}
    for path in paths:
        require_own(path)
    for path in reversed(paths):  # the file that names the others is the last
        path.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(path, paths[path])
    return made.notes


def _gazebo(scenario: Scenario, folder: str) -> exports.Exported:
    world = exported(scenario)
    return exports.Exported(sdf_files(world, folder), world.found.notes)


def _stonefish(scenario: Scenario, folder: str) -> exports.Exported:
    world = exported(scenario)
    return exports.Exported(stonefish_files(world, folder, scenario), world.found.notes)


GAZEBO, STONEFISH = exports.ScenarioExport("Gazebo", _gazebo), exports.ScenarioExport("Stonefish", _stonefish)
