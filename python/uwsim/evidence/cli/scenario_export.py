"""`uwsim scenario export`: write a scenario for Gazebo or Stonefish."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwsim.cli.bounds import writable
from uwsim.cli.options import ScenarioName


def scenario_export(
    scenario: ScenarioName,
    out: Annotated[Path, typer.Option(help="The file: .sdf or .scn.", callback=writable)] = Path("world.sdf"),
) -> None:
    """Write a scenario for Gazebo (.sdf) or Stonefish (.scn).

    The bed, the obstacles and the station become meshes, in a folder beside the file; each vehicle keeps its hull,
    mass, inertia, thrusters, cameras and sensors, in SDF its added mass and drag, in Stonefish its drag along its axes.
    All that is left out or assumed is printed.
    """
    from uwsim.evidence.export.write import write_export

    for note in write_export(scenario, out):
        typer.echo(note)
    typer.echo(str(out))
