"""`uwsim survey`: fly a survey, or resume one."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwsim.base.options import need
from uwsim.cli.flights import (
    Autosave,
    CloseLoops,
    Engine,
    Estimate,
    MapMemory,
    MinCoverage,
    Offsets,
    Out,
    OutlierFilter,
    Raw,
    Report,
    Resume,
    ScenarioOfFlight,
    TimeLimit,
    Uncertainty,
    VerifyMap,
    exit_as,
    given,
    require_consistent,
)
from uwsim.cli.groups import under
from uwsim.cli.options import (
    Frequency,
    Link,
    MissionTime,
    Record,
    Seed,
    SonarModel,
    SurveyTopics,
    Threads,
    VehicleModel,
    Voxel,
    hertz,
)
from uwsim.cli.options import sonar_model as parsed_sonar_model


@under("Fly")
def survey(
    scenario: ScenarioOfFlight = None,
    out: Out = Path("out"),
    mission: Annotated[
        str | None,
        typer.Option(
            help="MODULE:NAME of a mission of your own, such as my_missions:Spiral, or a Python file. "
            "Default: a lawn-mower."
        ),
    ] = None,
    seed: Seed = None,
    vehicle_model: VehicleModel = None,
    sonar_model: SonarModel = None,
    frequency: Frequency = None,
    mission_time: MissionTime = None,
    time_limit: TimeLimit = None,
    voxel: Voxel = None,
    threads: Threads = None,
    engine: Engine = None,
    verify_map: VerifyMap = False,
    autosave: Autosave = None,
    map_memory: MapMemory = None,
    outlier_filter: OutlierFilter = None,
    link: Link = None,
    estimate: Estimate = None,
    close_loops: CloseLoops = False,
    report: Report = "full",
    min_coverage: MinCoverage = None,
    record: Record = None,
    record_topic: SurveyTopics = None,
    raw: Raw = None,
    offsets: Offsets = None,
    uncertainty: Uncertainty = None,
    resume: Resume = False,
) -> None:
    """Fly the survey of a scenario, map what is seen, and report.

    Ctrl-C ends it early and keeps the map so far. If it is killed, the last saved map remains, and --resume continues
    to the same map as an uninterrupted run.
    """
    require_consistent(
        resume=resume, record=record, record_topic=record_topic, close_loops=close_loops, autosave=autosave,
        min_coverage=min_coverage, report=report, raw=raw,
    )  # fmt: skip
    if raw is None:
        need("--raw", offsets=offsets, uncertainty=uncertainty)
    from uwsim.flight.patch_errors import PatchErrors
    from uwsim.scoring.tpu import Uncertainties

    errors = None if offsets is None else PatchErrors.parse(offsets)
    known = None if uncertainty is None else Uncertainties.parse(uncertainty)
    if not resume:
        from uwsim.scenario.world_ahead import make_world_ahead

        make_world_ahead(scenario or "lake")
    from uwsim.flight.survey import resume_survey, run_survey

    asked = given(
        mission=mission, seed=seed, sonar_model=parsed_sonar_model(sonar_model), sonar_frequency_hz=hertz(frequency),
        vehicle_model=vehicle_model, mission_time_s=mission_time, time_limit_s=time_limit, voxel_m=voxel, engine=engine,
        verify_map=verify_map or None, outlier_filter=outlier_filter, link=link, estimate=estimate, threads=threads,
        map_memory_mb=map_memory, report=report, autosave_s=autosave,
    )  # fmt: skip
    if resume:
        flown = resume_survey(out, scenario=scenario, **asked)
    else:
        topics = tuple(record_topic or ()) or None
        flown = run_survey(
            scenario or "lake",
            out,
            close_loops=close_loops,
            record=record,
            record_topics=topics,
            raw=raw,
            raw_errors=errors,
            raw_known=known,
            **asked,
        )
    exit_as(flown, min_coverage)
