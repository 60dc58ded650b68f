"""`uwsim map`: inspect, convert, merge, score, draw and compare maps. Dependencies are imported only when needed."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwsim.base.sockets import registered
from uwsim.cli.exit_codes import FAILED
from uwsim.cli.groups import show_help
from uwsim.cli.options import SETTINGS, AsJson, print_json
from uwsim.cli.values import readable, scenarios, within

app = typer.Typer(
    name="uwsim map",
    help="Inspect, convert, score, draw and compare OctoMaps (.bt, .ot).",
    short_help="Inspect, convert, score, draw and compare maps.",
    invoke_without_command=True,
    callback=show_help,
    rich_help_panel="Scenarios and maps",
    **SETTINGS,
)

MAPS, CLOUDS, GRIDS = (
    [f".{name}" for name in registered(f"uwsim.kinds.{kind}_file")] for kind in ("map", "cloud", "grid")
)
"""Suffixes of all formats; uwsim.mapping.files.formats would be slow to import."""

MapFile = Annotated[Path, typer.Argument(help=f"A map, {' or '.join(MAPS)}.", callback=readable)]
FigureFile = Annotated[Path | None, typer.Option(help="The figure to write, a PNG.")]
MapOrigin = Annotated[
    tuple[float, float, float] | None,
    typer.Option(
        help="World coordinates of the file's zero: x y z [m]. Default: what the file states, else 0 0 0.",
        metavar="X Y Z",
        callback=within(-1e7, 1e7, "m"),
    ),
]


@app.command()
def info(
    source: MapFile,
    origin: MapOrigin = None,
    as_json: AsJson = False,
) -> None:
    """Print a map's format, resolution, counts, bounds and size."""
    from uwsim.mapping.info import map_info, map_values

    if as_json:
        print_json(map_values(source, origin))
        return
    rows = map_info(source, origin)
    width = max(len(name) for name, _ in rows)
    for name, value in rows:
        typer.echo(f"{name:<{width}}  {value}")


@app.command()
def convert(
    source: Annotated[
        Path,
        typer.Argument(
            help=f"A map ({', '.join(MAPS)}), a cloud ({', '.join(CLOUDS)}) or a survey (.gsf, .kmall, .xtf).",
            callback=readable,
        ),
    ],
    target: Annotated[
        Path,
        typer.Argument(help=f"The file to write: {' '.join((*MAPS, *CLOUDS))}, or {' '.join(GRIDS)} for a depth grid."),
    ],
    cell: Annotated[
        float | None,
        typer.Option(
            help="Width of a grid's cells [m]. Default: the map's voxels.", callback=within(0.001, 10_000, "m")
        ),
    ] = None,
    scenario: Annotated[
        str | None,
        typer.Option(help="The scenario whose place on Earth a cloud or a depth grid has.", autocompletion=scenarios),
    ] = None,
    origin: MapOrigin = None,
) -> None:
    """Convert a map, a cloud or a survey file to another format.

    A survey's grid is in its UTM zone, with the uncertainty of its soundings at 95 %. A .tif contains the median depth
    and the count of each cell. A .bt contains no probabilities: in an .ot converted from it, all voxels are at the
    clamping limits.
    """
    from uwsim.cli.map_convert import convert as convert_file

    what = convert_file(source, target, origin_world_m=origin, cell_m=cell, scenario=scenario)
    typer.echo(f"{target}: {what}")


@app.command()
def merge(
    sources: Annotated[
        list[Path], typer.Argument(help="Two or more maps with the same resolution.", callback=readable)
    ],
    out: Annotated[Path, typer.Option(help=f"The map to write, {' or '.join(MAPS)}.")],
) -> None:
    """Merge maps of one area, or of its parts.

    The result does not depend on their order. If all maps are .ot, their log-odds are added. A .bt contains no
    probabilities: if any map is a .bt, a voxel is occupied if it is occupied in any map.
    """
    from uwsim.mapping.merge import merge_files

    typer.echo(f"{out}: {merge_files(sources, out):,} occupied voxels")


@app.command()
def score(
    source: MapFile,
    scenario: Annotated[
        str,
        typer.Option(
            help="The map's scenario: name of a packaged one, or path of a YAML file.", autocompletion=scenarios
        ),
    ],
    track: Annotated[
        Path | None,
        typer.Option(
            help="The survey's track.npz, or a cloud of the sonar's positions. Default: beside the map.",
            callback=readable,
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="The figure of the errors to write. Default: beside the map.")
    ] = None,
    json: Annotated[Path | None, typer.Option(help="A JSON file to write the score to.")] = None,
    area: Annotated[
        tuple[float, float, float, float] | None,
        typer.Option(
            help="Score this box only: west south east north [m]. Default: the survey's area, or the map's extent.",
            metavar="W S E N",
            callback=within(-1e7, 1e7, "m"),
        ),
    ] = None,
    origin: MapOrigin = None,
) -> None:
    """Compare a map with the true world.

    Reports coverage, precision, recall, distances, and the seabed's accuracy by IHO S-44.
    """
    from rich.console import Console

    from uwsim.figures.map_plans import draw_map_errors
    from uwsim.scoring.score_map_file import score_map_file, score_table, write_score_json

    scored = score_map_file(source, scenario, track, origin, area)
    Console().print(score_table(scored, f"{source.name} against {scenario}"), highlight=False)
    if not scored.path_known:
        typer.echo("no track of the survey (--track): coverage and recall need it and are unknown")
    figure = require_png(out or source.with_name(f"{source.stem}.score.png"))
    draw_map_errors(figure, scored.score, scored.track.area_world_m)
    if json is not None:
        write_score_json(json, scored)
    typer.echo(str(figure))


@app.command()
def render(
    source: MapFile,
    out: FigureFile = None,
    azimuth: Annotated[
        float,
        typer.Option(
            help="Direction to the eye, counter-clockwise from east [deg].", callback=within(-360, 360, "deg")
        ),
    ] = -118.0,
    elevation: Annotated[
        float, typer.Option(help="Elevation of the eye above the horizon [deg].", callback=within(-89, 89, "deg"))
    ] = 38.0,
    width: Annotated[
        int, typer.Option(help="Width of the figure [pixels].", callback=within(200, 8000, "pixels"))
    ] = 1600,
    origin: MapOrigin = None,
) -> None:
    """Draw a map in 3D, without a display.

    Occupied voxels are coloured by height, as in octovis.
    """
    from uwsim.figures.map_render import Viewpoint, draw_map
    from uwsim.mapping.files.map_files import open_map

    viewpoint, figure = Viewpoint(azimuth, elevation, width), require_png(out or source.with_suffix(".png"))
    draw_map(figure, open_map(source, origin), viewpoint, source.name)
    typer.echo(str(figure))


@app.command()
def diff(
    first: MapFile,
    second: MapFile,
    out: FigureFile = None,
    exit_code: Annotated[bool, typer.Option("--exit-code", help="Exit with 1 if the maps differ.")] = False,
    as_json: AsJson = False,
) -> None:
    """Count the voxels whose states differ between two maps.

    The maps must have the same resolution. With --out, the voxels are also drawn.
    """
    from uwsim.figures.map_plans import draw_map_difference
    from uwsim.mapping.changes import STATES, map_difference
    from uwsim.mapping.files.map_files import open_map

    figure = None if out is None else require_png(out)
    found = map_difference(open_map(first), open_map(second))
    if figure is not None:
        draw_map_difference(figure, found, (first.name, second.name))
    if as_json:
        print_json({
            "states": STATES, "counts": found.counts, "differing": found.differing, "resolution_m": found.resolution_m,
        })  # fmt: skip
    else:
        typer.echo(f"voxels by state in {first} (rows) and {second} (columns)")
        typer.echo(f"{'':>10}" + "".join(f"{state:>14}" for state in STATES))
        for state, row in zip(STATES, found.counts, strict=True):
            typer.echo(f"{state:>10}" + "".join(f"{count:>14,}" for count in row))
        typer.echo(f"{found.differing:,} voxels differ" if found.differing else "the states of all voxels are the same")
        if figure is not None:
            typer.echo(str(figure))
    if exit_code and found.differing:
        raise typer.Exit(FAILED)


@app.command(name="slice")
def slice_(
    source: MapFile,
    x: Annotated[
        float | None, typer.Option(help="Vertical cut at this x (east) [m].", callback=within(-1e7, 1e7, "m"))
    ] = None,
    y: Annotated[
        float | None, typer.Option(help="Vertical cut at this y (north) [m].", callback=within(-1e7, 1e7, "m"))
    ] = None,
    z: Annotated[
        float | None, typer.Option(help="Horizontal cut at this height [m].", callback=within(-1e7, 1e7, "m"))
    ] = None,
    out: FigureFile = None,
    origin: MapOrigin = None,
) -> None:
    """Draw a horizontal or vertical slice of a map.

    It shows occupied, free and unknown voxels. Pass one of --x, --y, --z.
    """
    from uwsim.figures.map_plans import draw_map_slice
    from uwsim.mapping.files.map_files import open_map
    from uwsim.mapping.info import slice_map

    given = [(axis, at) for axis, at in (("x", x), ("y", y), ("z", z)) if at is not None]
    if len(given) != 1:
        raise ValueError(f"--x, --y, --z: {len(given)} of them given, must be one")
    axis, at_m = given[0]
    figure = require_png(out or source.with_name(f"{source.stem}.{axis}{at_m:g}.png"))
    draw_map_slice(figure, slice_map(open_map(source, origin), axis, at_m))  # type: ignore[arg-type]
    typer.echo(str(figure))


def require_png(path: Path) -> Path:
    """Return the path of a figure. Raises ValueError unless it ends in .png."""
    if path.suffix.lower() != ".png":
        raise ValueError(f"figure '{path}': must end in .png")
    return path
