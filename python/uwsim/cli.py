"""The `uwsim` command. Each command imports what it needs when it runs, so that --help answers at once."""

from __future__ import annotations

import os
import runpy
import signal
import sys
import warnings
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer

app = typer.Typer(
    name="uwsim",
    help="A fast, headless underwater robotics simulator: fly an ROV, sweep a multibeam, get an OctoMap.",
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # which would take a unit in brackets for markup, and leave it out
)

# Exit codes; 2 is typer's own for wrong options.
FAILED, STUCK, INTERRUPTED = 1, 3, 130

PASS_ON: dict[str, Any] = {"allow_extra_args": True, "ignore_unknown_options": True, "help_option_names": []}

ScenarioName = Annotated[str, typer.Argument(help="A packaged scenario's name, or the path of a YAML file.")]
Seed = Annotated[int | None, typer.Option(help="Replaces the scenario's seed.")]
SonarModel = Annotated[
    str | None,
    typer.Option(help="Replaces the scenario's: 1 to 4 as on the wire, a packaged model's name, or a YAML file."),
]
Frequency = Annotated[
    float | None, typer.Option(help="kHz, of a sonar that works at several; replaces the scenario's.")
]
Pose = Annotated[
    str | None,
    typer.Option(help="Of the vehicle, X,Y,Z [m][,YAW[,PITCH[,ROLL]]] [deg], PITCH nose down; its start without."),
]
MissionTime = Annotated[float | None, typer.Option(help="Seconds of battery; replaces the scenario's.")]
Threads = Annotated[int | None, typer.Option(help="Threads to use; the result does not depend on it. All by default.")]


@app.command()
def survey(
    scenario: Annotated[
        str | None, typer.Argument(help="A packaged scenario's name, or the path of a YAML file; lake by default.")
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for map.bt, report.html and the pictures.")] = Path("out"),
    seed: Seed = None,
    sonar_model: SonarModel = None,
    frequency: Frequency = None,
    mission_time: MissionTime = None,
    voxel: Annotated[float | None, typer.Option(help="Edge of the map's voxels [m]; replaces the scenario's.")] = None,
    threads: Threads = None,
    engine: Annotated[str | None, typer.Option(help="Of the map: bricks (default), or octomap for stock's.")] = None,
    verify_map: Annotated[
        bool, typer.Option("--verify-map", help="Map with stock OctoMap too, and exit with 1 if a byte differs.")
    ] = False,
    autosave: Annotated[float, typer.Option(help="Seconds of wall time between saves; 0 for none.")] = 30.0,
    map_memory: Annotated[
        float | None,
        typer.Option(help="Megabytes that the map may take of memory; the rest goes to disk. All without."),
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Fly on the survey that was last saved in --out.")] = False,
) -> None:
    """Fly the scenario's survey, map what the sonar sees, and report. Ctrl-C ends it early and keeps the map so far.

    Killed at any moment, it leaves the map of the last save; --resume flies on to the same map as uninterrupted.
    """
    from uwsim.survey.command import resume_survey, run_survey

    asked: dict[str, Any] = {
        "seed": seed,
        "sonar_model": _model(sonar_model),
        "sonar_frequency_khz": frequency,
        "mission_time_s": mission_time,
        "voxel_m": voxel,
        "engine": engine,
    }
    if resume:
        asked |= {"scenario": scenario, "verify_map": verify_map or None}
        record = resume_survey(out, threads=threads, autosave_s=autosave, map_memory_mb=map_memory, **asked)
    else:
        record = run_survey(
            scenario or "lake",
            out,
            threads=threads,
            autosave_s=autosave,
            map_memory_mb=map_memory,
            verify_map=verify_map,
            **asked,
        )
    if record.interrupted:
        raise typer.Exit(INTERRUPTED)
    if record.verified is False:
        raise typer.Exit(FAILED)
    if record.stopped_because.startswith(("stuck", "capsized")):
        raise typer.Exit(STUCK)


@app.command()
def scenario(
    name: Annotated[str | None, typer.Argument(help="A scenario to check; without one, all packaged ones.")] = None,
) -> None:
    """List the packaged scenarios, or check one whole, world and vehicles too, and say what is in it."""
    from uwsim.scenario import load, packaged_scenarios
    from uwsim.simulator import Simulator

    for known in packaged_scenarios() if name is None else [name]:
        checked = load(known)
        if name is not None:
            Simulator(checked)
        sonars = ", ".join(
            f"{v.name} with sonar model {v.sonar.title}" if v.model.sonar else f"{v.name} without a sonar"
            for v in checked.vehicles
        )
        typer.echo(f"{checked.name}: {' '.join(checked.description.split())}")
        typer.echo(f"  vehicles: {sonars}; obstacles: {len(checked.obstacles)}; seed {checked.seed}")


@app.command()
def sonar(
    scenario: ScenarioName = "lake",
    pose: Pose = None,
    out: Annotated[Path, typer.Option(help="The picture, a PNG.")] = Path("sonar.png"),
    kind: Annotated[
        str, typer.Option(help="fan (plan and section), image (forward-looking), side-scan, profile, all.")
    ] = "all",
    sonar_model: SonarModel = None,
    tilt: Annotated[
        float | None, typer.Option(help="Degrees nose down; without, the scenario's for the fan and 12 for the image.")
    ] = None,
    track: Annotated[float, typer.Option(help="Length of the side-scan's track straight ahead, metres.")] = 60.0,
    seed: Seed = None,
    frequency: Frequency = None,
) -> None:
    """Draw what the sonar sees from somewhere: the fan over the true bed, a sonar image, a side-scan's waterfall."""
    from uwsim.sonar_view.command import Request, run_sonar

    for line in run_sonar(Request(scenario, out, pose, kind, _model(sonar_model), tilt, track, seed, frequency)):
        typer.echo(line)


@app.command()
def validate(
    suites: Annotated[list[str] | None, typer.Argument(help="dynamics, sonar, imaging, camera; all without.")] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for the curves as PNG.")] = None,
) -> None:
    """Compare what runs with closed forms and published data: expected, got, error. Exits with 1 on a miss."""
    from uwsim.validate import SUITES, run_suite
    from uwsim.validate.report import show

    missed = False
    for suite in suites or SUITES:
        checks = run_suite(suite, out)
        show(checks, suite)
        missed = missed or not all(check.passed for check in checks)
    if missed:
        raise typer.Exit(FAILED)


@app.command()
def camera(
    scenario: ScenarioName = "lake",
    out: Annotated[Path, typer.Option(help="The picture: .png or .jpg.")] = Path("camera.png"),
    effects: Annotated[
        str, typer.Option(help="A picture for each, side by side: on, off, or names joined by + (comma-separated).")
    ] = "on",
    name: Annotated[str, typer.Option("--camera", help="Which: front, down, station, or another by name.")] = "front",
    pose: Pose = None,
    jerlov: Annotated[str | None, typer.Option(help="Water type: I, IA, IB, II, III, 1C, 3C, 5C, 7C, 9C.")] = None,
    sun: Annotated[float | None, typer.Option(help="The sun's elevation [deg].")] = None,
    lamps: Annotated[str, typer.Option(help="Lamps that are on, comma-separated: front, down.")] = "",
    at: Annotated[float, typer.Option(help="Simulated time to let pass first [s].")] = 0.0,
    seed: Seed = None,
    threads: Threads = None,
) -> None:
    """Take pictures, with and without the water's effects."""
    from uwsim.gallery import Wish, draw

    wanted = [part for part in effects.split(",") if part]
    if not wanted:
        raise ValueError(f"effects = {effects!r}: must name at least one picture")
    wish = Wish(name, wanted, pose, jerlov, sun, [part for part in lamps.split(",") if part], at)
    frames = draw(scenario, wish, out, seed=seed, threads=threads)
    typer.echo(f"{out}: {len(frames)} x {frames[0].info.width} x {frames[0].info.height} pixels, camera '{name}'")


@app.command()
def decompose(
    mesh: Annotated[Path, typer.Argument(help="A closed mesh: OBJ, STL, PLY, glTF.")],
    out: Annotated[Path | None, typer.Option(help="Where to write; MESH.pieces.obj beside it by default.")] = None,
    threshold: Annotated[float, typer.Option(help="Hollows that may stay, relative to the mesh's size.")] = 0.1,
    max_pieces: Annotated[int, typer.Option(min=1, help="How many pieces at most.")] = 24,
) -> None:
    """Cut a vehicle's hull into convex pieces for `collision: pieces`. Takes ten seconds to minutes; needs CoACD."""
    from uwsim.scenario import closed_mesh, load_mesh
    from uwsim.scenario.collision_shapes import decompose as decompose_mesh
    from uwsim.scenario.collision_shapes import write_pieces

    vertices, triangles = closed_mesh(*load_mesh(mesh), name=str(mesh))
    pieces = decompose_mesh(vertices, triangles, threshold=threshold, max_pieces=max_pieces)
    target = out or mesh.with_suffix(".pieces.obj")
    write_pieces(pieces, target, made_from=mesh.name)
    typer.echo(f"{target}: {len(pieces)} convex pieces")


# Options, --help among them, are the benchmark's own.
@app.command(context_settings=PASS_ON)
def bench(
    context: typer.Context, name: Annotated[str, typer.Argument(help="Which benchmark; none lists them.")] = ""
) -> None:
    """Measure: medians, and where the time goes. `uwsim bench survey --help` lists that benchmark's options."""
    folder = _bench_folder()
    known = ", ".join(sorted(path.stem for path in folder.glob("*.py")))
    if name in ("", "--help"):
        typer.echo(f"benchmarks: {known}; uwsim bench NAME --help lists the options of one")
        return
    if name not in known.split(", "):
        raise ValueError(f"benchmark '{name}': unknown; there are: {known}")
    program = typer.Typer(add_completion=False, pretty_exceptions_enable=False, rich_markup_mode=None)
    program.command()(runpy.run_path(str(folder / f"{name}.py"))["main"])
    _run(program, context.args, f"uwsim bench {name}")


# Its commands have options of their own, --help among them; they are loaded when one is called.
@app.command(name="map", context_settings=PASS_ON)
def map_(context: typer.Context) -> None:
    """Look into, convert, score, draw and compare maps: info, convert, merge, score, render, diff, slice."""
    from uwsim.maps.cli import app as map_app

    _run(map_app, context.args or ["--help"], "uwsim map")


def _run(program: typer.Typer, arguments: list[str], name: str) -> None:
    """A program of the command's own. Raises what it raises, typer.Exit where it asks for another code than 0."""
    code = program(args=arguments, prog_name=name, standalone_mode=False)
    if code:
        raise typer.Exit(code)


def _bench_folder() -> Path:
    """Inside the package where it is installed, at the root of the repository where it is not."""
    package = Path(__file__).resolve().parent
    return next(f for f in (package / "bench", package.parents[1] / "tools" / "bench") if f.is_dir())


def _model(given: str | None) -> int | str | None:
    """A number on the wire, or a name or path."""
    return int(given) if given is not None and given.isascii() and given.isdigit() else given


def main() -> NoReturn:
    """Entry point: a user's mistake is one line on stderr and a non-zero exit, not a traceback."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _quit)
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(errors="replace")  # type: ignore[union-attr]  # a terminal that knows only ASCII
    warnings.showwarning = _show_warning
    try:
        code = app(args=sys.argv[1:] or ["--help"], prog_name="uwsim", standalone_mode=False)
    except (ValueError, OSError, MemoryError) as error:
        if os.environ.get("UWSIM_TRACEBACK"):
            raise
        _complain(str(error) or type(error).__name__)
        sys.exit(FAILED)
    except Exception as error:
        # Of a wrong option; where typer keeps its class depends on the version.
        if not hasattr(error, "format_message"):
            raise
        _complain(error.format_message().rstrip("."))
        sys.exit(getattr(error, "exit_code", FAILED))
    sys.exit(code if isinstance(code, int) else 0)


def _complain(message: str) -> None:
    """On one line, whatever a library's message looks like."""
    typer.echo(f"uwsim: error: {' '.join(message.split())}", err=True)


def _quit(number: int, frame: object) -> NoReturn:
    """At once: an exception in the middle of an import may be swallowed there, or leave it half done."""
    os.write(2, b"uwsim: interrupted\n")
    os._exit(INTERRUPTED)


def _show_warning(message: Warning | str, category: type[Warning], *_: Any, **__: Any) -> None:
    """A user's scenario may call for a warning; what libraries tell programmers does not."""
    if issubclass(category, UserWarning):
        typer.echo(f"uwsim: warning: {message}", err=True)
