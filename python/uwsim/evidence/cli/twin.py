"""`uwsim twin`: yesterday's dive as a scenario, with its model beside its log."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwsim.cli.bounds import readable, within
from uwsim.cli.groups import under
from uwsim.cli.options import Threads
from uwsim.recording.cli.real_flight import LogColumns, LogOutputs


@under("Check")
def twin(
    area: Annotated[Path, typer.Option(help="The area: a polygon in GeoJSON or KML, or a plan.", callback=readable)],
    chart: Annotated[Path, typer.Option(help="A chart of its bed: GeoTIFF, BAG, S-102, ...", callback=readable)],
    log: Annotated[Path, typer.Option(help="The dive: .BIN, .tlog, a ROS bag, a table.", callback=readable)],
    vehicle: Annotated[str, typer.Option(help="The vehicle: a name or a YAML file.")] = "bluerov2_heavy",
    out: Annotated[Path, typer.Option(help="A folder for site.yaml, report.md and bed.csv.")] = Path("twin"),
    columns: LogColumns = None,
    outputs: LogOutputs = None,
    density: Annotated[
        float, typer.Option(help="Density of the water [kg/m3].", callback=within(900, 1100, "kg/m3"))
    ] = 1025.0,
    water_level: Annotated[
        float,
        typer.Option(help="The chart's elevation of the water surface [m].", callback=within(-12_000, 10_000, "m")),
    ] = 0.0,
    threads: Threads = None,
) -> None:
    """Make a scenario of a dive; fly its model beside the log.

    The world is the chart's square about the area, which the survey mows. The report states what is measured, what is
    assumed, what is missing and unknown, and the model's error by horizon.
    """
    from uwsim.evidence.twin import make_twin

    made = make_twin(
        area,
        chart,
        log,
        vehicle,
        out,
        columns=columns,
        outputs=outputs,
        density_kg_m3=density,
        water_level_m=water_level,
        threads=threads,
    )
    for line in made.notes:
        typer.echo(line)
    for path in made.paths:
        typer.echo(str(path))
