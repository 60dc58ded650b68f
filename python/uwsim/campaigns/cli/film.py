"""`uwsim film`: a film of a recorded run, of a mission, or of a scenario's survey."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

import typer

from uwsim.campaigns.cli.sweep import Scheduler, Workers
from uwsim.cli.bounds import within
from uwsim.cli.choices import one_of
from uwsim.cli.exit_codes import INTERRUPTED
from uwsim.cli.groups import under
from uwsim.cli.options import VehicleName


@under("Look")
def film(
    source: Annotated[
        str, typer.Argument(help="A recording (.mcap), a mission's file (.py), or a scenario, whose survey is flown.")
    ],
    out: Annotated[Path, typer.Option(help="The film to write: .mp4 or .webp.")] = Path("film.mp4"),
    scenario: Annotated[str | None, typer.Option(help="Where a mission is flown. Default: lake.")] = None,
    camera: Annotated[
        str,
        typer.Option(
            help="chase, orbit, a camera of the vehicle, or a CSV file: time_s,x_m,y_m,z_m,at_x_m,at_y_m,at_z_m."
        ),
    ] = "chase",
    vehicle: VehicleName = None,
    size: Annotated[str, typer.Option(help="Pixels.", metavar="WxH")] = "1280x720",
    fps: Annotated[float, typer.Option(help="Frames per second.", callback=within(1, 200, "Hz"))] = 30.0,
    quality: Annotated[
        str,
        typer.Option(
            help="Pictures of which each frame is the mean: draft 1, good 4, high 16.",
            **one_of("draft", "good", "high"),
        ),
    ] = "good",
    from_s: Annotated[
        float, typer.Option("--from", help="First simulated time [s].", callback=within(0, 1e6, "s"))
    ] = 0.0,
    until_s: Annotated[
        float, typer.Option("--until", help="Last simulated time [s].", callback=within(0.01, 1e6, "s"))
    ] = 3600.0,
    workers: Workers = None,
    scheduler: Scheduler = None,
    resume: Annotated[bool, typer.Option("--resume", help="Render the frames that are missing.")] = False,
) -> None:
    """Film a run from any camera.

    Pictures have many rays a pixel, motion blur and soft shadows. The run is repeated bit for bit, so a recording can
    be filmed again and again, from other places. The frames are kept in a folder beside the film, which may be removed;
    their bytes do not depend on the number of workers.
    """
    from uwsim.base.stoppable import stop_on_signals
    from uwsim.campaigns.film import make_film
    from uwsim.campaigns.workers.job_progress import job_progress

    if scenario is not None and Path(source).suffix != ".py":
        raise ValueError("--scenario: has an effect only with a mission's file (.py)")
    pixels = re.fullmatch(r"(\d{1,4})x(\d{1,4})", size)
    if pixels is None or min(found := (int(pixels[1]), int(pixels[2]))) < 1:
        raise ValueError(f"--size {size}: must be WxH, such as 1920x1080")
    with job_progress("frames", "rendering") as progress, stop_on_signals(progress):
        made = make_film(
            source, out, scenario=scenario or "lake", camera=camera, vehicle=vehicle, size=found, fps=fps,
            quality=quality, from_s=from_s, until_s=until_s, workers=workers, scheduler=scheduler, resume=resume,
            stop_requested=progress.stop_requested, tell=progress.tell, show=progress.abandonable,
        )  # fmt: skip
    if made.interrupted:
        typer.echo(f"interrupted after {made.finished:,} of {made.frames:,} frames; --resume continues", err=True)
        raise typer.Exit(INTERRUPTED)
    typer.echo(f"{made.out}: {made.frames:,} frames, {made.frames / fps:.1f} s")
