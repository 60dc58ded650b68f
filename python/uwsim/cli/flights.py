"""Options of flights, shared by `uwsim survey` and `uwsim run`, and their exit codes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from uwsim.base.options import need
from uwsim.base.sockets import registered
from uwsim.cli.bounds import within
from uwsim.cli.choices import one_of
from uwsim.cli.exit_codes import FAILED, INCOMPLETE, INTERRUPTED, STUCK
from uwsim.cli.values import scenarios

if TYPE_CHECKING:
    from uwsim.flight.record import FlightRecord

Out = Annotated[
    Path, typer.Option(help="Folder for map.bt, report.html, summary.json, log.jsonl and track-VEHICLE.csv.")
]
ScenarioOfFlight = Annotated[
    str | None,
    typer.Argument(
        help="Name of a packaged scenario, or path of a YAML file. Default: lake.", autocompletion=scenarios
    ),
]
Engine = Annotated[
    str | None,
    typer.Option(
        help="Engine of the map: bricks (default), or octomap, the stock library.", **one_of("bricks", "octomap")
    ),
]
VerifyMap = Annotated[
    bool, typer.Option("--verify-map", help="Also build a stock OctoMap map; exit with 1 if a byte differs.")
]
MapMemory = Annotated[
    float | None,
    typer.Option(
        help="Limit of the map's memory [MB]; the rest of the map goes to disk. Default: no limit.",
        callback=within(0.001, 1e9, "MB"),
    ),
]
OutlierFilter = Annotated[
    bool | None,
    typer.Option(
        "--outlier-filter/--no-outlier-filter",
        help="Discard ranges with which their neighbours in the swath disagree. Default: in physics mode.",
    ),
]
Estimate = Annotated[
    str | None,
    typer.Option(
        help="Poses by which vehicles steer and maps are built: truth (default), or filter, estimated from the "
        "vehicle's own instruments.",
        **one_of("truth", "filter"),
    ),
]
CloseLoops = Annotated[
    bool,
    typer.Option(
        "--close-loops",
        help="With a map and --estimate filter: after the flight, adjust the track until overlapping observations "
        "agree, and rebuild the map. Such a flight is not autosaved.",
    ),
]
TimeLimit = Annotated[
    float | None,
    typer.Option(
        help="End the flight after this simulated time [s]. Default: the battery's.", callback=within(0.001, 1e9, "s")
    ),
]
Report = Annotated[
    str,
    typer.Option(
        help="full: report.html, figures and summary.json; json: summary.json alone; none: neither, and no score.",
        **one_of("full", "json", "none"),
    ),
]
MinCoverage = Annotated[
    float | None,
    typer.Option(
        help="Exit with 4 if the map's coverage is below this [%]. "
        "Default: 95 for a survey that ended early, 0 for one that flew all its lanes.",
        callback=within(0, 100, "%"),
    ),
]
Autosave = Annotated[
    float | None,
    typer.Option(help="Wall time between saves [s]; 0 for none. Default: 30.", callback=within(0, 1e6, "s")),
]
Raw = Annotated[
    Path | None,
    typer.Option(
        help="Also write every mapped ping with its travel times for survey software: "
        f"{' or '.join(f'.{name}' for name in registered('uwsim.kinds.survey_file'))}; all but .pd0 need earth: in the "
        "scenario."
    ),
]
Offsets = Annotated[
    str | None,
    typer.Option(
        help="With --raw: errors of installation in that file, to be found by calibration: roll, pitch, heading [deg], "
        "latency [s], such as roll=0.5,latency=0.02."
    ),
]
Uncertainty = Annotated[
    str | None,
    typer.Option(
        help="With --raw: standard deviations of the survey's instruments, for the errors that the file states and the "
        "order of S-44: roll, pitch, heading, mount, angle [deg], position, depth, heave, tide, lever, "
        "range [m], latency [s], sound_speed, surface_speed [m/s], such as roll=0.05,position=0.5."
    ),
]
Resume = Annotated[bool, typer.Option("--resume", help="Continue the flight last saved in --out.")]


def given(**options: Any) -> dict[str, Any]:
    """Return the options that are not None."""
    return {name: value for name, value in options.items() if value is not None}


def require_consistent(
    *, resume: bool, record: Path | None, record_topic: list[str] | None, close_loops: bool, autosave: float | None,
    min_coverage: float | None, report: str, raw: Path | None = None,
) -> None:  # fmt: skip
    """Raise ValueError or WithoutEffectError for options that contradict each other."""
    if min_coverage and report == "none":
        raise ValueError("--min-coverage: needs a score of the map, which --report none leaves out")
    if resume and record is not None:
        raise ValueError("--record: a flight that is resumed cannot be recorded from its start")
    if resume and raw is not None:
        raise ValueError("--raw: a flight that is resumed has no pings from its start")
    if close_loops and autosave:
        raise ValueError(f"--autosave {autosave:g} s: a flight with --close-loops is not autosaved")
    if resume and close_loops:
        raise ValueError("--close-loops: such a flight is not saved, so it cannot be resumed")
    if record is None:
        need("--record", record_topic=record_topic)


def exit_as(flown: FlightRecord, min_coverage: float | None = None) -> None:
    """Exit with the code for how the flight ended; return if it succeeded."""
    from uwsim.flight.summary import coverage_shortfall

    if flown.interrupted:
        raise typer.Exit(INTERRUPTED)
    if flown.verified is False:
        raise typer.Exit(FAILED)
    if flown.ended_because.startswith(("stuck", "capsized")):
        raise typer.Exit(STUCK)
    if flown.planned or min_coverage is not None:
        if (shortfall := coverage_shortfall(flown, min_coverage)) is not None:
            typer.echo(f"uwsim: {shortfall}", err=True)
            raise typer.Exit(INCOMPLETE)
    elif flown.ended_early:
        raise typer.Exit(INCOMPLETE)
