"""`uwsim recording diff`: find where two recordings diverge."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from uwsim.cli.exit_codes import FAILED
from uwsim.cli.options import AsJson, print_json
from uwsim.cli.values import readable

if TYPE_CHECKING:
    from uwsim.recording.diff import Comparison

SHOWN = 10


def diff(
    first: Annotated[Path, typer.Argument(help="A recording.", metavar="A.mcap", callback=readable)],
    second: Annotated[Path, typer.Argument(help="Another recording.", metavar="B.mcap", callback=readable)],
    out: Annotated[Path, typer.Option(help="The figure to write if they differ, a PNG.")] = Path("divergence.png"),
    as_json: AsJson = False,
) -> None:
    """Compare two recordings and find where they diverge.

    Prints the first tick and channel that differ and by how much, and plots the divergence.

    Exits with 1 if any message differs.
    """
    from uwsim.recording.diff import diff as compare
    from uwsim.recording.reader import Recording

    if out.suffix.lower() != ".png":
        raise ValueError(f"--out {out}: must end in .png")
    found = compare(Recording(first), Recording(second))
    gaps = {parting.topic: parting.gaps for parting in found.partings if parting.gaps}
    if gaps:
        from uwsim.figures.comparison import draw_divergence

        draw_divergence(out, gaps, f"{first.name} and {second.name}")
    if as_json:
        partings = [
            {"channel": f"/{each.topic}", "tick": each.tick, "difference": each.text, "messages": each.messages}
            for each in found.partings
        ]
        print_json({"same": found.same, "messages": found.compared, "notes": found.notes, "partings": partings})
    else:
        _print(found, out if gaps else None)
    if not found.same:
        raise typer.Exit(FAILED)


def _print(found: Comparison, figure: Path | None) -> None:
    for note in found.notes:
        typer.echo(note)
    if found.same:
        typer.echo(f"the same: {found.compared:,} messages")
    for parting in found.partings[:SHOWN]:
        typer.echo(f"tick {parting.tick}, /{parting.topic}: {parting.text} ({parting.messages:,} messages differ)")
    if len(found.partings) > SHOWN:
        typer.echo(f"and {len(found.partings) - SHOWN} more channels")
    if figure is not None:
        typer.echo(str(figure))
