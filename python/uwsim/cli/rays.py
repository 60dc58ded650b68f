"""`uwsim scenario rays`: all arrivals of sound between two points, as a table and as a figure of their rays."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Annotated

import typer

from uwsim.cli.options import ScenarioName
from uwsim.cli.values import within


def rays(
    source: Annotated[str, typer.Option("--from", help="Position of the source: X,Y,Z [m].")],
    receiver: Annotated[str, typer.Option("--to", help="Position of the receiver: X,Y,Z [m].")],
    scenario: ScenarioName = "lake",
    out: Annotated[Path | None, typer.Option(help="The figure to write, a PNG or an SVG. Default: no figure.")] = None,
    frequency: Annotated[float, typer.Option(help="Frequency [Hz].", callback=within(100, 1e6, "Hz"))] = 25_000.0,
    within_db: Annotated[
        float, typer.Option("--within", help="Weaker arrivals are left out [dB].", callback=within(0, 200, "dB"))
    ] = 20.0,
    as_json: Annotated[bool, typer.Option("--json", help="Print the arrivals as JSON.")] = False,
) -> None:
    """Find all arrivals of sound between two points.

    Prints travel time, level, angles, bounces and turning points of each, and draws the rays beside the profile of the
    speed of sound. The bottom is flat, of the material that the scenario's link specifies (silt without a link), and at
    the depth of the bed half-way between the points; a warning states how far the bed departs from it.
    """
    from uwsim.instruments.acoustics.rays_between import rays_between, text_table
    from uwsim.scenario import load

    found = rays_between(
        load(scenario),
        _point("--from", source),
        _point("--to", receiver),
        frequency_hz=frequency,
        within_db=within_db,
    )
    if out is not None:
        from uwsim.figures.rays import draw_rays

        draw_rays(found, out)
    typer.echo(json.dumps(found.as_dict(), indent=1) if as_json else text_table(found))
    if found.warning:
        typer.echo(f"warning: {found.warning}", err=True)
    if out is not None:
        typer.echo(f"rays over the profile: {out}", err=as_json)


def _point(option: str, text: str) -> tuple[float, float, float]:
    try:
        x, y, z = (float(part) for part in text.split(","))
    except ValueError:
        x = y = z = math.nan
    if not all(map(math.isfinite, (x, y, z))):
        raise ValueError(f"{option} {text}: must be X,Y,Z: three finite numbers, metres")
    return x, y, z
