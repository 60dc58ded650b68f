"""`uwsim map`: what can be done with a finished map. Each command imports what it needs when it runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(
    name="uwsim map",
    help="Look into, convert, score, draw and compare OctoMaps (.bt, .ot).",
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # which would take a unit in brackets for markup, and leave it out
)

DIFFERENT = 1

MapFile = Annotated[Path, typer.Argument(help="A map, .bt or .ot.")]
Picture = Annotated[Path | None, typer.Option(help="The picture to write, a PNG.")]
MapOrigin = Annotated[
    tuple[float, float, float],
    typer.Option(help="Where the file's zero lies in the world: x y z [m].", metavar="X Y Z"),
]
ZERO = (0.0, 0.0, 0.0)


@app.command()
def info(source: MapFile, origin: MapOrigin = ZERO) -> None:
    """Tell a map's format, resolution, counts, bounds and size."""
    from uwsim.maps.info import map_facts

    facts = map_facts(source, origin)
    width = max(len(name) for name, _ in facts)
    for name, value in facts:
        typer.echo(f"{name:<{width}}  {value}")


@app.command()
def convert(
    source: Annotated[Path, typer.Argument(help="A map (.bt, .ot) or a cloud (.ply, .pcd, .las, .xyz).")],
    target: Annotated[Path, typer.Argument(help="What to write: .bt .ot .ply .pcd .las .xyz, or .tif for depths.")],
    cell: Annotated[float | None, typer.Option(help="Width of a .tif's cells [m]; by default a voxel's.")] = None,
    scenario: Annotated[str | None, typer.Option(help="Whose terrain places a .tif on Earth.")] = None,
    origin: MapOrigin = ZERO,
) -> None:
    """Write a map or a cloud in another format; a .tif holds the median depth and the count of each cell.

    A .bt knows no degrees: an .ot made of it has all its voxels at the limits of certainty.
    """
    from uwsim.maps.convert import convert as convert_file

    what = convert_file(source, target, origin_world_m=origin, cell_m=cell, scenario=scenario)
    typer.echo(f"{target}: {what}")


@app.command()
def merge(
    sources: Annotated[list[Path], typer.Argument(help="Two maps or more, of one resolution.")],
    out: Annotated[Path, typer.Option(help="The map to write, .bt or .ot.")],
) -> None:
    """Make one map of several, the sum of their log-odds. Give .ot files if there are any: a .bt knows no degrees."""
    from uwsim.maps.merge import merge_files

    typer.echo(f"{out}: {merge_files(sources, out):,} occupied voxels")


@app.command()
def score(
    source: MapFile,
    scenario: Annotated[str, typer.Option(help="The scenario it was made in: a packaged one's name or a YAML file.")],
    track: Annotated[
        Path | None, typer.Option(help="The survey's track.npz, or a cloud of the sonar's positions; beside the map.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="The picture of where it is wrong; beside the map.")] = None,
    json: Annotated[Path | None, typer.Option(help="Write the figures here, too.")] = None,
    origin: MapOrigin = ZERO,
) -> None:
    """Compare a map with the true world: coverage, precision, recall, distances, the seabed by IHO S-44."""
    from rich.console import Console

    from uwsim.maps.scoring import draw_score, score_file, score_table, write_score_json

    scored = score_file(source, scenario, track, origin)
    Console().print(score_table(scored, f"{source.name} against {scenario}"), highlight=False)
    if not scored.path_known:
        typer.echo("no track of the survey (--track): coverage and recall, of what could be seen, are not known")
    picture = _png(out or source.with_name(f"{source.stem}.score.png"))
    draw_score(picture, scored)
    if json is not None:
        write_score_json(json, scored)
    typer.echo(str(picture))


@app.command()
def render(
    source: MapFile,
    out: Picture = None,
    azimuth: Annotated[float, typer.Option(help="Of the camera, from east, counter-clockwise [deg].")] = -118.0,
    elevation: Annotated[float, typer.Option(help="Of the camera above the horizon [deg].")] = 38.0,
    width: Annotated[int, typer.Option(help="Of the picture [pixels].")] = 1600,
    origin: MapOrigin = ZERO,
) -> None:
    """Draw a map's occupied voxels in 3D, coloured by height, as octovis does; needs no display."""
    from uwsim.maps.files import open_map
    from uwsim.maps.render import Camera, draw_map

    camera, picture = Camera(azimuth, elevation, width), _png(out or source.with_suffix(".png"))
    draw_map(picture, open_map(source, origin), camera, source.name)
    typer.echo(str(picture))


@app.command()
def diff(
    first: MapFile,
    second: MapFile,
    out: Picture = None,
    exit_code: Annotated[bool, typer.Option("--exit-code", help="Exit with 1 when the maps differ.")] = False,
) -> None:
    """Count the voxels whose state differs between two maps of one resolution; with --out draw where."""
    from uwsim.maps.compare import STATES, difference, draw_difference
    from uwsim.maps.files import open_map

    picture = None if out is None else _png(out)
    found = difference(open_map(first), open_map(second))
    typer.echo(f"{first} (down), {second} (across): voxels")
    typer.echo(f"{'':>10}" + "".join(f"{state:>14}" for state in STATES))
    for state, row in zip(STATES, found.counts, strict=True):
        typer.echo(f"{state:>10}" + "".join(f"{count:>14,}" for count in row[:-1]) + f"{row[-1]:>14,}")
    typer.echo(f"{found.differing:,} voxels differ" if found.differing else "the states of all voxels are the same")
    if picture is not None:
        draw_difference(picture, found, (first.name, second.name))
        typer.echo(str(picture))
    if exit_code and found.differing:
        raise typer.Exit(DIFFERENT)


@app.command(name="slice")
def slice_(
    source: MapFile,
    x: Annotated[float | None, typer.Option(help="Cut upright, across east, here [m].")] = None,
    y: Annotated[float | None, typer.Option(help="Cut upright, across north, here [m].")] = None,
    z: Annotated[float | None, typer.Option(help="Cut level at this height [m].")] = None,
    out: Picture = None,
    origin: MapOrigin = ZERO,
) -> None:
    """Draw a level or an upright cut: occupied, free, unknown. Give one of --x, --y, --z."""
    from uwsim.maps.files import open_map
    from uwsim.maps.slices import draw_slice, slice_map

    given = [(axis, at) for axis, at in (("x", x), ("y", y), ("z", z)) if at is not None]
    if len(given) != 1:
        raise ValueError(f"--x, --y, --z: {len(given)} of them given, must be one")
    axis, at_m = given[0]
    picture = _png(out or source.with_name(f"{source.stem}.{axis}{at_m:g}.png"))
    draw_slice(picture, slice_map(open_map(source, origin), axis, at_m))  # type: ignore[arg-type]
    typer.echo(str(picture))


def _png(path: Path) -> Path:
    if path.suffix.lower() != ".png":
        raise ValueError(f"picture '{path}': must end in .png")
    return path
