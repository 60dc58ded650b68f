"""`uwsim survey`: fly a survey, or resume one."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from uwsim.cli.bounds import within
from uwsim.cli.choices import one_of
from uwsim.cli.exit_codes import FAILED, INCOMPLETE, INTERRUPTED, STUCK
from uwsim.cli.options import Frequency, Link, MissionTime, Record, Seed, SonarModel, SurveyTopics, Threads, Voxel, need
from uwsim.cli.options import sonar_model as parsed_sonar_model
from uwsim.cli.values import scenarios


def survey(
    scenario: Annotated[
        str | None,
        typer.Argument(
            help="Name of a packaged scenario, or path of a YAML file. Default: lake.", autocompletion=scenarios
        ),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for map.bt, report.html and the figures.")] = Path("out"),
    mission: Annotated[
        str | None,
        typer.Option(help="MODULE:NAME of a mission of your own, such as my_missions:Spiral. Default: a lawn-mower."),
    ] = None,
    seed: Seed = None,
    sonar_model: SonarModel = None,
    frequency: Frequency = None,
    mission_time: MissionTime = None,
    voxel: Voxel = None,
    threads: Threads = None,
    engine: Annotated[
        str | None,
        typer.Option(
            help="Engine of the map: bricks (default), or octomap, the stock library.",
            **one_of("bricks", "octomap"),
        ),
    ] = None,
    verify_map: Annotated[
        bool, typer.Option("--verify-map", help="Also build a stock OctoMap map; exit with 1 if a byte differs.")
    ] = False,
    autosave: Annotated[
        float, typer.Option(help="Wall time between saves [s]; 0 for none.", callback=within(0, 1e6, "s"))
    ] = 30.0,
    map_memory: Annotated[
        float | None,
        typer.Option(
            help="Limit of the map's memory [MB]; the rest of the map goes to disk. Default: no limit.",
            callback=within(0.001, 1e9, "MB"),
        ),
    ] = None,
    outlier_filter: Annotated[
        bool | None,
        typer.Option(
            "--outlier-filter/--no-outlier-filter",
            help="Discard ranges with which their neighbours in the swath disagree. Default: in physics mode.",
        ),
    ] = None,
    link: Link = None,
    estimate: Annotated[
        str | None,
        typer.Option(
            help="truth, or filter: fly and map by the vehicle's own instruments. Default: truth.",
            **one_of("truth", "filter"),
        ),
    ] = None,
    close_loops: Annotated[
        bool,
        typer.Option(
            "--close-loops",
            help="With --estimate filter: mend the drift of the map where its parts overlap. Not saved as it flies.",
        ),
    ] = False,
    report: Annotated[
        str,
        typer.Option(
            help="full: report.html, figures, summary.json; json: summary.json alone; none: map.bt alone, no score.",
            **one_of("full", "json", "none"),
        ),
    ] = "full",
    min_coverage: Annotated[
        float | None,
        typer.Option(
            help="Exit with 4 if the coverage is below this [%]. "
            "Default: 95 for a survey that ended early, 0 for one that flew all its lanes.",
            callback=within(0, 100, "%"),
        ),
    ] = None,
    record: Record = None,
    record_topic: SurveyTopics = None,
    resume: Annotated[bool, typer.Option("--resume", help="Continue the survey last saved in --out.")] = False,
) -> None:
    """Fly the survey of a scenario, map what is seen, and report.

    Ctrl-C ends it early and keeps the map so far. If it is killed, the last saved map remains; --resume continues to
    the same map as without the interruption.
    """
    if min_coverage is not None and not 0.0 <= min_coverage <= 100.0:  # false for nan, too
        raise ValueError(f"--min-coverage {min_coverage:g} %: must be in [0, 100] %")
    if min_coverage and report == "none":
        raise ValueError("--min-coverage: needs a score of the map, which --report none leaves out")
    if not resume:
        from uwsim.scenario.world_ahead import make_world_ahead

        make_world_ahead(scenario or "lake")
    from uwsim.survey.completeness import coverage_shortfall
    from uwsim.survey.run import AUTOSAVE_S, resume_survey, run_survey

    arguments: dict[str, Any] = {
        "mission": mission,
        "seed": seed,
        "sonar_model": parsed_sonar_model(sonar_model),
        "sonar_frequency_khz": frequency,
        "mission_time_s": mission_time,
        "voxel_m": voxel,
        "engine": engine,
        "outlier_filter": outlier_filter,
        "estimate": estimate,
        "link": link,
    }
    if resume and record is not None:
        raise ValueError("--record: a survey that is resumed cannot be recorded from its start")
    if close_loops and autosave not in (0.0, AUTOSAVE_S):
        raise ValueError(f"--autosave {autosave:g} s: a survey with --close-loops is not saved as it flies")
    if resume and close_loops:
        raise ValueError("--close-loops: such a survey is not saved, so it cannot be resumed")
    if record is None:
        need("--record", record_topic=record_topic)
    if record is not None and record.suffix != ".mcap":
        raise ValueError(f"--record {record}: must end in .mcap for a survey")
    if resume:
        arguments |= {"scenario": scenario, "verify_map": verify_map or None}
        flown = resume_survey(
            out, threads=threads, autosave_s=autosave, map_memory_mb=map_memory, report=report, **arguments
        )
    else:
        arguments["estimate"] = estimate or "truth"
        flown = run_survey(
            scenario or "lake",
            out,
            threads=threads,
            autosave_s=autosave,
            map_memory_mb=map_memory,
            report=report,
            verify_map=verify_map,
            close_loops=close_loops,
            record=record,
            record_topics=tuple(record_topic) if record_topic else None,
            **arguments,
        )
    if flown.interrupted:
        raise typer.Exit(INTERRUPTED)
    if flown.verified is False:
        raise typer.Exit(FAILED)
    if flown.stopped_because.startswith(("stuck", "capsized")):
        raise typer.Exit(STUCK)
    if (shortfall := coverage_shortfall(flown, min_coverage)) is not None:
        typer.echo(f"uwsim: {shortfall}", err=True)
        raise typer.Exit(INCOMPLETE)
