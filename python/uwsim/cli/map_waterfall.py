"""`uwsim map waterfall`: the picture of a side-scan survey."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwsim.cli.map import FigureFile, require_png
from uwsim.cli.values import readable


def waterfall(
    source: Annotated[Path, typer.Argument(help="A side-scan survey, FILE.xtf.", callback=readable)],
    out: FigureFile = None,
    over_ground: Annotated[
        bool, typer.Option("--over-ground", help="By range over a level bed, from the altitudes in the file.")
    ] = False,
) -> None:
    """Draw a survey file's side scan, port on the left."""
    from uwsim.mapping.files.swath import survey_of

    read = survey_of(source, "waterfall").read_side_scan
    if read is None:
        raise ValueError(f"waterfall {source}: this format holds no side scan")
    figure = require_png(out or source.with_suffix(".png"))
    head, lines = read(source)
    from uwsim.figures.side_scan_file import draw_side_scan  # here, since matplotlib takes a second

    count = draw_side_scan(figure, head, lines, source.name, over_ground=over_ground)
    typer.echo(f"{figure}: {count:,} pings, {head.range_max_m:g} m to either side")
