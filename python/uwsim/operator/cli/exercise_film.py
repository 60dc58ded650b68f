"""`uwsim exercise film`: the decisive half minutes of a recorded run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwsim.cli.bounds import readable, writable
from uwsim.cli.options import Threads


def film(
    recording: Annotated[Path, typer.Argument(help="The run's recording, FILE.mcap.", callback=readable)],
    sheet: Annotated[
        Path | None,
        typer.Option(help="The attempt's score.json. Default: none, and contacts are shown.", callback=readable),
    ] = None,
    out: Annotated[Path, typer.Option(help="The film to write, .webp.", callback=writable)] = Path("debrief.webp"),
    camera: Annotated[str, typer.Option(help="chase, orbit, or a camera of the vehicle.")] = "chase",
    lang: Annotated[str, typer.Option(help="The language of its words: en or de.")] = "en",
    threads: Threads = None,
) -> None:
    """Film the decisive half minutes of a run.

    They are those around each goal that was met, each limit that was broken, and the end; without a sheet, around each
    contact. Beside the picture is the chart, below it what was judged, and the run's time line. The run is repeated bit
    for bit. A film has two minutes at most; the moments that count least are left out.
    """
    from uwsim.exercises.certified import read_sheet
    from uwsim.exercises.debrief import FPS, film_debrief

    judged = None if sheet is None else read_sheet(sheet)
    shares: list[int] = []

    def show(share: float) -> None:
        if not shares or shares[-1] < int(100 * share):
            shares.append(int(100 * share))
            typer.echo(f"{shares[-1]} %", err=True)

    shown = film_debrief(recording, out, judged, camera=camera, threads=threads, lang=lang, on_share=show)
    for frames in shown:
        typer.echo(f"{frames.start / FPS:8.1f} s to {frames.stop / FPS:.1f} s")
    typer.echo(str(out))
