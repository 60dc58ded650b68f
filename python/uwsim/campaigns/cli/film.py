"""`uwsim recording film`: a film of a recorded run, of a mission, or of a scenario's survey."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwsim.campaigns.workers.options import CampaignOptions
from uwsim.cli.exit_codes import INTERRUPTED
from uwsim.recording.filming.options import FilmOptions


def film(
    *,
    source: Annotated[
        str, typer.Argument(help="A recording (.mcap), a mission's file (.py), or a scenario, whose survey is flown.")
    ],
    out: Annotated[Path, typer.Option(help="The film to write: .mp4 or .webp.")] = Path("film.mp4"),
    scenario: Annotated[str | None, typer.Option(help="Where a mission is flown. Default: lake.")] = None,
    wanted: FilmOptions,
    work: CampaignOptions,
) -> None:
    """Film a run from any camera.

    Pictures have many rays a pixel, motion blur and soft shadows. The run is repeated bit for bit, so a recording can
    be filmed again and again, from other places. The frames are kept in a folder beside the film, which may be removed;
    their bytes do not depend on the number of workers.
    """
    from uwsim.campaigns.film import make_film
    from uwsim.campaigns.workers.job_progress import job_progress

    if scenario is not None and Path(source).suffix != ".py":
        raise ValueError("--scenario: has an effect only with a mission's file (.py)")
    with job_progress("frames", "rendering") as progress:
        options = wanted.arguments | work.arguments | progress.arguments | {"show": progress.abandonable}
        made = make_film(source, out, scenario=scenario or "lake", **options)
    if made.interrupted:
        typer.echo(f"interrupted after {made.finished:,} of {made.frames:,} frames; --resume continues", err=True)
        raise typer.Exit(INTERRUPTED)
    typer.echo(f"{made.out}: {made.frames:,} frames, {made.frames / wanted.fps:.1f} s")
