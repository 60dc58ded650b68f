"""`uwsim scenario from`: a scenario from a chart, or from the published simulator's Unity project."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwsim.base.options import need
from uwsim.cli.bounds import within

SCENE, TERRAIN = "LawnTest", "SolidTerrain"
SIZE_M = 500.0


def from_source(
    source: Annotated[
        Path, typer.Argument(help="A chart (BAG, GeoTIFF, NetCDF, ...), or a checkout of the Unity project.")
    ],
    size: Annotated[
        float | None,
        typer.Option(help="A chart: the largest edge [m]. Default: 500.", callback=within(5, 20_000, "m")),
    ] = None,
    centre: Annotated[
        tuple[float, float] | None,
        typer.Option(
            help="A chart: the middle, in its coordinates. Default: that of the largest square without gaps.",
            metavar="X Y", callback=within(-1e9, 1e9, ""),
        ),
    ] = None,
    water_level: Annotated[
        float | None,
        typer.Option(
            help="A chart: its elevation of the water surface [m]. Default: 0.", callback=within(-12_000, 10_000, "m")
        ),
    ] = None,
    scene: Annotated[
        str | None, typer.Option(help=f"Unity: the scene, by its file's name without .unity. Default: {SCENE}.")
    ] = None,
    terrain: Annotated[
        str | None, typer.Option(help=f"Unity: the top-level object that is the bed. Default: {TERRAIN}.")
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(help="A chart: the YAML file to write. Unity: the folder. Default: the chart's or scene's name."),
    ] = None,
) -> None:  # fmt: skip
    """Make a scenario from a chart, or from the published simulator's Unity project.

    Of a chart, the largest square without gaps becomes the bed, at its place on Earth, with a vehicle and a survey in
    its middle; elevations are positive up. Of a Unity project, the meshes (FBX) and places of a scene and its prefabs
    are read: bed, station, gates, pipelines, vehicle. The vehicle's file is drafted from its hull, as by `uwsim vehicle
    --draft`; water, optics and survey are those of the scenario `paper`. All that is left out is printed.
    """
    if source.is_dir():
        need("a chart", size=size, centre=centre, water_level=water_level)
        _from_unity(source, scene or SCENE, terrain or TERRAIN, out)
        return
    if not source.is_file():
        raise FileNotFoundError(f"'{source}': no such file or folder")
    need("a Unity project", scene=scene, terrain=terrain)
    from uwsim.scenario.from_chart import scenario_from_chart

    target = out or Path(source.stem.lower().replace(" ", "_") + ".yaml")
    made = scenario_from_chart(source, target, size_m=size or SIZE_M, centre=centre, water_level_m=water_level or 0.0)
    typer.echo(
        f"{made.path}: {made.size_m:g} x {made.size_m:g} m, {made.depth_m[0]:.1f} to {made.depth_m[1]:.1f} m deep; "
        f"uwsim survey {made.path}"
    )


def _from_unity(checkout: Path, scene: str, terrain: str, out: Path | None) -> None:
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
