"""Options of flights, shared by `uwsim survey` and `uwsim run`, and their exit codes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from uwsim.base.options import Options, option
from uwsim.cli.exit_codes import FAILED, INCOMPLETE, INTERRUPTED, STUCK
from uwsim.cli.options import VOXEL, VOXELS
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


@dataclass(frozen=True)
class MapOptions(Options):
    """The options of a flight's map. Raises WithoutEffectError."""

    voxel_m: float | None = option(None, VOXEL, bounds=VOXELS)
    engine: str | None = option(
        None, "Engine of the map: bricks (default), or octomap, the stock library.", choices=("bricks", "octomap")
    )
    verify_map: bool = option(False, "Also build a stock OctoMap map; exit with 1 if a byte differs.")
    outlier_filter: bool | None = option(
        None, "Discard ranges with which their neighbours in the swath disagree. Default: in physics mode."
    )
    min_coverage: float | None = option(
        None,
        "Exit with 4 if the map's coverage is below this [%]. Default: 95 for a survey that ended early, 0 for one "
        "that flew all its lanes.",
        bounds=(0, 100, "%"),
    )

    @property
    def arguments(self) -> dict[str, Any]:
        """Those that are given, as arguments of `fly`."""
        return {name: value for name, value in super().arguments.items() if name != "min_coverage"}


@dataclass(frozen=True)
class FlightOptions(Options):
    """The options of any flight."""

    estimate: str | None = option(
        None,
        "Poses by which vehicles steer and maps are built: truth (default), or filter, estimated from the vehicle's "
        "own instruments.",
        choices=("truth", "filter"),
    )
    time_limit_s: float | None = option(
        None, "End the flight after this simulated time [s]. Default: the battery's.", bounds=(0.001, 1e9, "s")
    )
    report: str = option(
        "full",
        "full: report.html, figures and summary.json; json: summary.json alone; none: neither, and no score.",
        choices=("full", "json", "none"),
    )
    autosave_s: float | None = option(
        None, "Wall time between saves of the map [s]; 0 for none. Default: 30.", bounds=(0, 1e6, "s")
    )

    def require_fit(self, maps: MapOptions) -> None:
        """Raise ValueError for options that contradict each other."""
        if maps.min_coverage and self.report == "none":
            raise ValueError("--min-coverage: needs a score of the map, which --report none leaves out")


def given(**options: Any) -> dict[str, Any]:
    """Return the options that are not None."""
    return {name: value for name, value in options.items() if value is not None}


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
