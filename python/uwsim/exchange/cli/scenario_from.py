"""`uwsim scenario from`: a scenario from a chart, or from the files of another simulator."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Literal

import typer

from uwsim.base.options import OptionError
from uwsim.cli.values import within

RARE_S = 2.0
"""Between two lines on progress, and before the first."""


def scenario_from(
    source: Annotated[Path, typer.Argument(help="A file, or a checkout (of a robot, or Unity).")],
    size: Annotated[
        float | None,
        typer.Option(
            help="The bed's largest edge [m]. Default: 500 of a chart, all (2000 at most) of a Unity project.",
            callback=within(5, 20_000, "m"),
        ),
    ] = None,
    centre: Annotated[
        tuple[float, float] | None,
        typer.Option(
            help="The middle: in a chart's coordinates (default: of the largest square without gaps); of a Unity "
            "project, metres east and north of its origin.",
            metavar="X Y", callback=within(-1e9, 1e9, ""),
        ),
    ] = None,
    water_level: Annotated[
        float | None,
        typer.Option(
            help="A chart: its elevation of the water surface [m]. Default: 0.", callback=within(-12_000, 10_000, "m")
        ),
    ] = None,
    unit: Annotated[
        Literal["m", "ft", "us-ft"] | None, typer.Option(help="A chart: the unit of its heights. Default: its own.")
    ] = None,
    nodata: Annotated[
        float | None,
        typer.Option(
            help="A chart: the value of cells without data. Default: its own.", callback=within(-1e38, 1e38, "")
        ),
    ] = None,
    positive: Annotated[
        Literal["up", "down"] | None, typer.Option(help="A chart: down, if its heights are depths. Default: up.")
    ] = None,
    crs: Annotated[
        str | None, typer.Option(help="A chart: its coordinate system, such as EPSG:32632. Default: its own.")
    ] = None,
    cell: Annotated[
        float | None,
        typer.Option(
            help="Soundings: the width of a cell, in the unit of their x. Default: by their density.",
            callback=within(1e-9, 1e6, ""),
        ),
    ] = None,
    scene: Annotated[
        str | None, typer.Option(help="Unity: the scene, by its file's name without .unity. Default: LawnTest.")
    ] = None,
    terrain: Annotated[
        str | None, typer.Option(help="Unity: the top-level object that is the bed. Default: SolidTerrain.")
    ] = None,
    arguments: Annotated[
        list[str] | None,
        typer.Option("--arg", help="A robot: an argument of xacro or Stonefish, once for each.", metavar="NAME=VALUE"),
    ] = None,
    data: Annotated[
        Path | None,
        typer.Option(help="Stonefish: the folder of its resources. Default: looked for above the file."),
    ] = None,
    outfit: Annotated[
        Literal["survey"] | None,
        typer.Option(help="A robot: give it what a survey needs and it lacks, a multibeam and an altimeter."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(help="A chart: the YAML file to write. Others: the folder. Default: the source's own name."),
    ] = None,
) -> None:  # fmt: skip
    """Make a scenario from a chart or a simulator's files.

    Of a chart (BAG, GeoTIFF, NetCDF, ...), the largest square without gaps becomes the bed, at its place on Earth, with
    a vehicle and a survey in its middle; elevations are positive up. Of a robot's description (SDF, URDF, Stonefish's
    .scn), the scenario and its vehicles are written, with hulls, mass, hydrodynamics, thrusters and
    sensors; files that it refers to are looked for beside it. Of a Unity project, bed, station, gates, pipelines and
    vehicle are read, with their materials' colours, of a picture its mean. All that is left out or
    assumed is printed.
    """
    from uwsim.exchange.scenario_source import NotMadeError, source_of

    found = source_of(source)
    options = {
        "size": size, "centre": centre, "water_level": water_level, "unit": unit, "nodata": nodata,
        "positive": positive, "crs": crs, "cell": cell, "scene": scene, "terrain": terrain,
        "arguments": arguments and _arguments(arguments), "data": data, "outfit": outfit,
    }  # fmt: skip
    given: dict[str, object] = {key: value for key, value in options.items() if value is not None}
    for key in given.keys() - {*found.options}:
        raise OptionError(f"--{'arg' if key == 'arguments' else key.replace('_', '-')}: is not for {found.what}")
    if "progress" in found.options:
        given["progress"] = _rare_lines()
    try:
        made = found.read(source, out, given)
    except NotMadeError as error:
        for note in error.notes:
            typer.echo(str(note), err=True)
        raise
    for note in made.notes:
        typer.echo(str(note))
    typer.echo(f"{made.path}: fly it with uwsim station {made.path}")


def _rare_lines() -> Callable[[str], None]:
    """Return what prints the newest line to stderr once a while, and nothing of what is over sooner."""
    last_s = time.monotonic()

    def show(line: str) -> None:
        nonlocal last_s
        if time.monotonic() - last_s > RARE_S:
            last_s = time.monotonic()
            typer.echo(f"uwsim: {line}", err=True)

    return show


def _arguments(given: list[str]) -> dict[str, str]:
    """Return arguments by name. Raises OptionError."""
    for each in given:
        if not each.partition("=")[0].strip() or "=" not in each:
            raise OptionError(f"--arg {each}: must be NAME=VALUE")
    return {name.strip(): value for name, _, value in (each.partition("=") for each in given)}
