"""`uwsim vehicle identify`: a vehicle's coefficients from a log of its motion."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from uwsim.base.options import need
from uwsim.cli.options import AsJson, Threads, print_json
from uwsim.cli.values import readable, within
from uwsim.recording.cli.real_flight import LogColumns, LogOutputs


def identify(
    log: Annotated[
        Path,
        typer.Argument(
            help="A recording, an MCAP file, a ROS bag, a log of an autopilot (.BIN, .tlog) or a table.",
            metavar="LOG",
            callback=readable,
        ),
    ],
    vehicle: Annotated[str, typer.Option(help="The vehicle as far as it is known: a packaged name or a YAML file.")],
    mapping: Annotated[
        Path | None,
        typer.Option(
            "--map",
            help="Mapping file: where the log has each quantity. Not needed for uwsim's recordings.",
            callback=readable,
        ),
    ] = None,
    columns: LogColumns = None,
    outputs: LogOutputs = None,
    out: Annotated[
        Path,
        typer.Option(
            help="A copy of the vehicle's file with the identified values (.yaml), or a folder for vehicle.yaml, "
            "report.md and residuals.png."
        ),
    ] = Path("identified"),
    known: Annotated[
        list[str] | None, typer.Option(help="A quantity to hold, such as mass_kg or added_mass; may be repeated.")
    ] = None,
    spread: Annotated[
        list[str] | None, typer.Option(help="Prior standard deviation, as NAME=STANDARD_DEVIATION; may be repeated.")
    ] = None,
    name: Annotated[str, typer.Option(help="The vehicle's name in a recording of several.")] = "",
    segment: Annotated[
        float, typer.Option(help="Length of the segments that are simulated [s].", callback=within(1, 1e4, "s"))
    ] = 60.0,
    density: Annotated[
        float, typer.Option(help="Density of the water [kg/m3].", callback=within(900, 1100, "kg/m3"))
    ] = 1000.0,
    threads: Threads = None,
    as_json: AsJson = False,
) -> None:
    """Identify a vehicle's coefficients from a log.

    Estimates mass, centres of mass and buoyancy, a volume that the vehicle's file does not state, added mass, linear
    and quadratic drag, thrust gain and lag, the current and the commands' delay, with 95 % intervals; the report lists
    what the log does not determine. The log must be from well below the surface or, of a boat, from calm water.

    The vehicle's new file is its old one with the values that the log determines; the comment of each such line states
    the log and the interval. All other lines stay as they are, comments included.
    """
    from uwsim.base.own_files import require_own
    from uwsim.evidence.identification import identify as identified
    from uwsim.evidence.identification import read_log
    from uwsim.evidence.identification.calibrated_file import write_calibrated
    from uwsim.evidence.identification.report import table, undetermined_lines, write_report
    from uwsim.exchange.logs.motion_log import read_flown, read_mapping
    from uwsim.scenario import load_vehicle
    from uwsim.scenario.read.assets import YAML_SUFFIXES
    from uwsim.scenario.read.note import Note

    is_file = out.suffix.lower() in YAML_SUFFIXES
    if is_file:
        require_own(out)
    model = load_vehicle(vehicle)
    if mapping is not None:
        need("identification without --map", columns=columns, outputs=outputs)
        motion, notes = read_log(log, read_mapping(mapping), name), list[Note]()
    else:
        motion, notes = read_flown(log, model, name, columns, outputs)
    for note in notes:
        typer.echo(str(note), err=as_json)
    found = identified(
        motion,
        model,
        spreads=_spreads(spread or []),
        known=tuple(known or ()),
        segment_s=segment,
        density_kg_m3=density,
        threads=threads,
    )
    found = replace(found, premises=(*found.premises, *(str(note) for note in notes if note.kind != "known")))
    if is_file:
        write_calibrated(found, log.name, out)
    written = [out] if is_file else write_report(found, log.name, out)
    if as_json:
        values = [
            {"name": v.name, "unit": v.unit, "before": v.before, "value": v.value, "low": v.low, "high": v.high,
             "is_determined": v.is_determined}
            for v in found.values.values()
        ]  # fmt: skip
        print_json({"values": values, "premises": list(found.premises), "undetermined": undetermined_lines(found),
                    "files": list(map(str, written))})  # fmt: skip
        return
    rows = [("quantity", "before", "identified", "95 % from", "to", "unit", "from the log"), *table(found)]
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    for row in rows:
        typer.echo("  ".join(text.ljust(width) for text, width in zip(row, widths, strict=True)).rstrip())
    for line in found.premises:
        typer.echo(line)
    for line in undetermined_lines(found):
        typer.echo(f"not determined: {line}")
    for path in written:
        typer.echo(str(path))


def _spreads(given: list[str]) -> dict[str, float]:
    spreads = {}
    for text in given:
        key, _, value = text.partition("=")
        try:
            spreads[key] = float(value)
        except ValueError:
            raise ValueError(f"--spread {text}: must be NAME=NUMBER") from None
    return spreads
