"""`uwsim survey`: fly a survey."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from uwsim.base.options import Options, option
from uwsim.cli.flights import FlightOptions, MapOptions, Out, ScenarioOfFlight, exit_as, given
from uwsim.cli.groups import under
from uwsim.cli.options import SimulatorOptions
from uwsim.flight.attachment import Attachments

ENTRIES = ("north", "north-east", "east", "south-east", "south", "south-west", "west", "north-west")


@dataclass(frozen=True)
class LaneOptions(Options):
    """The options of a survey's lanes, in place of the scenario's."""

    area: Path | None = option(
        None,
        "Survey the area of this file, a polygon in GeoJSON or KML or the survey of a QGroundControl plan, in place of "
        "the scenario's.",
        metavar="FILE",
    )
    heading_deg: float | None = option(
        None, "Direction of the lanes, clockwise from north [deg].", bounds=(0, 360, "deg")
    )
    altitude_m: float | None = option(None, "Height of the lanes above the bed [m].", bounds=(0.5, 500, "m"))
    spacing_m: float | None = option(None, "Distance between the lanes [m].", bounds=(0.5, 500, "m"))
    speed: float | None = option(
        None, "Speed along the lanes [m/s]; 0.5 if the scenario has no survey.", bounds=(0.05, 5, "m/s")
    )
    entry: str | None = option(None, "Side or corner of the area where the lanes begin.", choices=ENTRIES)
    cross_lines: int | None = option(
        None, "Number of lanes across all others, which are flown after them.", bounds=(0, 50, "")
    )
    overlap: float | None = option(
        None,
        "Overlap of neighbouring swaths on a flat bed [%], which decides the lanes' distance.",
        bounds=(0, 95, "%"),
    )


@under("Fly")
def survey(
    *,
    scenario: ScenarioOfFlight = None,
    out: Out = Path("out"),
    mission: Annotated[
        str | None,
        typer.Option(
            help="MODULE:NAME of a mission of your own, such as my_missions:Spiral, or a Python file. "
            "Default: a lawn-mower."
        ),
    ] = None,
    lanes: LaneOptions,
    simulator: SimulatorOptions,
    maps: MapOptions,
    flight: FlightOptions,
    attachments: Attachments,
) -> None:
    """Fly the survey of a scenario, map what is seen, and report.

    Ctrl-C ends it early and keeps the map so far. If it is killed, the last saved map remains.
    """
    flight.require_fit(maps)
    asked = given(mission=mission) | simulator.arguments | maps.arguments | flight.arguments
    from uwsim.scenario.world_ahead import make_world_ahead

    if lanes.arguments:
        from uwsim.flight.request import survey_changes

        asked["survey"] = survey_changes(scenario or "lake", **lanes.arguments)
    make_world_ahead(scenario or "lake")
    from uwsim.flight.survey import run_survey

    flown = run_survey(scenario or "lake", out, **attachments.arguments, **asked)
    exit_as(flown, maps.min_coverage)
