"""`uwsim map film`: a film of how a recorded survey's map grew."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwsim.cli.values import readable, within, writable


def film(
    source: Annotated[Path, typer.Argument(help="A survey's recording, FILE.mcap.", callback=readable)],
    out: Annotated[Path, typer.Option(help="The film to write, .webp or .gif.", callback=writable)] = Path("map.webp"),
    pictures: Annotated[int, typer.Option(help="Number of pictures.", callback=within(2, 1000))] = 60,
    seconds: Annotated[float, typer.Option(help="How long it lasts [s].", callback=within(1, 600, "s"))] = 12.0,
    width: Annotated[
        int, typer.Option(help="Width of the truth and of the map [pixels].", callback=within(100, 2000, "pixels"))
    ] = 640,
) -> None:
    """Draw a film of the map that grows beside the truth.

    The number above it is the mean distance of the map's occupied voxels from the true surface.
    """
    from uwsim.recording.reader import Recording
    from uwsim.recording.survey_from import film_of

    count = film_of(Recording(source), out, pictures=pictures, seconds=seconds, width=width)
    typer.echo(f"{out}: {count} pictures")
