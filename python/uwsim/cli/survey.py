"""`uwsim survey`: fly a survey, or resume one."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwsim.cli.flights import FlightOptions, MapOptions, Out, ScenarioOfFlight, exit_as, given
from uwsim.cli.groups import under
from uwsim.cli.options import SimulatorOptions
from uwsim.flight.attachment import Attachments


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
    simulator: SimulatorOptions,
    maps: MapOptions,
    flight: FlightOptions,
    attachments: Attachments,
) -> None:
    """Fly the survey of a scenario, map what is seen, and report.

    Ctrl-C ends it early and keeps the map so far. If it is killed, the last saved map remains, and --resume continues
    to the same map as an uninterrupted run.
    """
    flight.require_fit(maps, attachments)
    asked = given(mission=mission) | simulator.arguments | maps.arguments | flight.arguments
    if flight.resume:
        from uwsim.flight.survey import resume_survey

        exit_as(resume_survey(out, scenario=scenario, **asked), maps.min_coverage)
        return
    from uwsim.scenario.world_ahead import make_world_ahead

    make_world_ahead(scenario or "lake")
    from uwsim.flight.survey import run_survey

    flown = run_survey(scenario or "lake", out, **attachments.arguments, **asked)
    exit_as(flown, maps.min_coverage)
