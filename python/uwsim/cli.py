"""The `uwsim` command. Each command imports what it needs when it runs, so that --help answers at once."""

from __future__ import annotations

import os
import runpy
import signal
import sys
from pathlib import Path
from typing import Annotated, NoReturn

import typer

app = typer.Typer(
    name="uwsim",
    help="A fast, headless underwater robotics simulator: fly an ROV, sweep a multibeam, get an OctoMap.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

FAILED, INTERRUPTED = 1, 130  # exit codes; 2 is typer's own for wrong options

ScenarioName = Annotated[str, typer.Argument(help="A packaged scenario's name, or the path of a YAML file.")]
Seed = Annotated[int | None, typer.Option(help="Replaces the scenario's seed.")]
SonarModel = Annotated[int | None, typer.Option(help="EM 2040 variant 1 to 4; replaces the scenario's.")]
MissionTime = Annotated[float | None, typer.Option(help="Seconds of battery; replaces the scenario's.")]
Threads = Annotated[int | None, typer.Option(help="Threads to use; the result does not depend on it. All by default.")]


@app.command()
def survey(
    scenario: ScenarioName = "lake",
    out: Annotated[Path, typer.Option(help="Folder for map.bt, report.html and the pictures.")] = Path("out"),
    seed: Seed = None,
    sonar_model: SonarModel = None,
    mission_time: MissionTime = None,
    voxel: Annotated[float | None, typer.Option(help="Edge of the map's voxels [m]; replaces the scenario's.")] = None,
    threads: Threads = None,
) -> None:
    """Fly the scenario's survey, map what the sonar sees, and report. Ctrl-C ends it early and keeps the map so far."""
    from uwsim.survey.command import run_survey

    stopped_early = run_survey(
        scenario,
        out,
        seed=seed,
        sonar_model=sonar_model,
        mission_time_s=mission_time,
        voxel_m=voxel,
        threads=threads,
    )
    if stopped_early:
        raise typer.Exit(INTERRUPTED)


@app.command()
def scenario(
    name: Annotated[
        str | None, typer.Argument(help="A scenario to check and describe; all are listed without.")
    ] = None,
) -> None:
    """List the packaged scenarios, or check one and say what is in it."""
    from uwsim.scenario import load, packaged_scenarios

    for known in packaged_scenarios() if name is None else [name]:
        checked = load(known)
        sonars = ", ".join(f"{v.name} with sonar model {v.sonar.model}" for v in checked.vehicles)
        typer.echo(f"{checked.name}: {' '.join(checked.description.split())}")
        typer.echo(f"  vehicles: {sonars}; obstacles: {len(checked.obstacles)}; seed {checked.seed}")


@app.command(context_settings={"allow_extra_args": True, "ignore_unknown_options": True})
def bench(context: typer.Context, name: Annotated[str, typer.Argument(help="Which benchmark: survey.")]) -> None:
    """Measure: prints medians and where the time goes. `uwsim bench survey --help` lists a benchmark's options."""
    folder = _bench_folder()
    known = sorted(path.stem for path in folder.glob("*.py"))
    if name not in known:
        raise ValueError(f"benchmark '{name}': unknown; there are: {', '.join(known)}")
    sys.argv = [f"uwsim bench {name}", *context.args]
    runpy.run_path(str(folder / f"{name}.py"), run_name="__main__")


def _bench_folder() -> Path:
    """Inside the package where it is installed, at the root of the repository where it is not."""
    package = Path(__file__).resolve().parent
    return next(f for f in (package / "bench", package.parents[1] / "tools" / "bench") if f.is_dir())


def main() -> NoReturn:
    """Entry point: a user's mistake is one line on stderr and a non-zero exit, not a traceback."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        app()
    except (ValueError, OSError) as error:
        if os.environ.get("UWSIM_TRACEBACK"):
            raise
        typer.echo(f"uwsim: error: {error}", err=True)
        sys.exit(FAILED)
    except KeyboardInterrupt:
        typer.echo("uwsim: interrupted", err=True)
        sys.exit(INTERRUPTED)
    sys.exit(0)
