"""What a flight prints: its key figures on stdout, all else on stderr."""

from __future__ import annotations

from pathlib import Path

from rich.markup import escape
from rich.table import Table
from rich.text import Text

from uwsim.flight.record import FlightRecord
from uwsim.flight.results import REPORT, SUMMARY
from uwsim.flight.summary import key_figures, vehicle_figures, warnings
from uwsim.survey.checkpoint import MAP
from uwsim.survey.terminal import Terminal


def print_flight(flown: FlightRecord, out: Path, screen: Terminal) -> None:
    """Print the key figures, why the flight ended, and where its results are."""
    table = Table(
        title=f"{escape(flown.mission)} in {escape(flown.scenario)}"
        + ("" if flown.seed is None else f", seed {flown.seed}"),
        title_justify="left",
        show_header=False,
    )
    table.add_column("figure", style="cyan", overflow="fold")
    table.add_column("value", justify="right", no_wrap=True)
    for name, value in key_figures(flown):
        table.add_row(name, value)
    for vehicle, samples in flown.samples.items():
        table.add_section()
        for name, value in vehicle_figures(samples):
            table.add_row(f"{vehicle}: {name}" if len(flown.samples) > 1 else name, value)
    if told := warnings(flown):
        table.caption = Text("\n".join(f"warning: {warning}" for warning in told), style="bold yellow")
        table.caption_justify = "left"
    screen.result(table)
    screen.result(f"ended because {flown.ended_because}")
    screen.result("  ".join(str(out / name) for name in (MAP, REPORT, SUMMARY) if (out / name).exists()))
