"""`uwsim scenario from`: a scenario from the published simulator's Unity project."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

SCENE = "LawnTest"


def from_unity(
    checkout: Annotated[Path, typer.Argument(help="A checkout of the Unity project, which contains Assets.")],
    scene: Annotated[str, typer.Option(help="The scene, by its file's name without .unity.")] = SCENE,
    terrain: Annotated[str, typer.Option(help="The top-level object that is the bed.")] = "SolidTerrain",
    out: Annotated[Path | None, typer.Option(help="The folder to write. Default: the scene's name.")] = None,
) -> None:
    """Make a scenario from the published simulator's Unity project.

    Reads the meshes (FBX) and places of a scene and its prefabs: bed, station, gates, pipelines, vehicle. The
    vehicle's file is drafted from its hull, as by `uwsim vehicle --draft`; water, optics and survey are those of the
    scenario `paper`. All that is left out is printed.
    """
    from uwsim.evidence.unity.project import Project
    from uwsim.evidence.unity.scenario import scenario_from

    project = Project(checkout)
    found = sorted(path for path in (checkout / "Assets").rglob("*.unity") if path.stem == scene)
    if not found:
        scenes = ", ".join(sorted(path.stem for path in (checkout / "Assets").rglob("*.unity")))
        raise ValueError(f"--scene = {scene!r}: must be one of {scenes}" if scenes else f"'{checkout}': has no scenes")
    made = scenario_from(project, found[0], out or Path(scene.lower().replace(" ", "_")), terrain=terrain)
    for note in made.notes:
        typer.echo(note)
    typer.echo(f"{made.path}: fly it with uwsim station {made.path}")
