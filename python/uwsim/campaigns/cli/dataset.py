"""`uwsim dataset`: labelled camera and sonar images, for machine learning."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from uwsim.base.did_you_mean import did_you_mean
from uwsim.base.options import WithoutEffectError, need
from uwsim.campaigns.cli.sweep import Scheduler, Workers
from uwsim.cli.bounds import UsageError, readable, within
from uwsim.cli.exit_codes import INTERRUPTED
from uwsim.cli.groups import under
from uwsim.cli.options import Seed, VehicleName
from uwsim.cli.values import packaged, packaged_folder, scenarios

if TYPE_CHECKING:
    from uwsim.campaigns.datasets import Dataset
    from uwsim.campaigns.datasets.sequences import Sequence

Vary = Annotated[
    list[str] | None,
    typer.Option(
        help="A parameter drawn for each frame: NAME=LOW..HIGH or NAME=A,B,C, such as optics.jerlov=II,3C. Repeatable.",
        metavar="NAME=VALUES",
    ),
]


OF_SEQUENCES = (
    "scenario", "out", "camera", "vehicle", "seed", "sequence", "time_limit", "instruments", "without", "no_bag",
)  # fmt: skip
"""The options that have an effect on a sequence."""
OF_NAMED = ("out", "sequence", "no_bag")
"""The options that have an effect on a packaged sequence."""


def _is_packaged(sequence: str) -> bool:
    """Return whether this names a packaged sequence; a mission's file of the same name comes first."""
    return sequence in _packaged() and not Path(sequence).is_file()


def _packaged() -> list[str]:
    return sorted(path.stem for path in (packaged_folder("assets", "assets") / "sequences").glob("*.yaml"))


def _readable_or_packaged(param: typer.CallbackParam, value: str | None) -> str | None:
    if value is None or _is_packaged(value):
        return value
    if not Path(value).exists():
        known = _packaged()
        rule = f"must be a mission's file, or one of {', '.join(known)}{did_you_mean(value, known)}"
        raise UsageError(f"--sequence = '{value}': {rule}")
    return readable(param, Path(value)) and value


@under("Fly")
def dataset(
    context: typer.Context,
    scenario: Annotated[
        str | None,
        typer.Argument(
            help="Name of a packaged scenario, or path of a YAML file; none for a named --sequence.",
            autocompletion=scenarios,
            show_default=False,
        ),
    ] = None,
    n: Annotated[int, typer.Option("--n", help="Number of frames.", callback=within(1, 1e9))] = 100,
    out: Annotated[Path, typer.Option(help="Folder for the pictures and their tables.")] = Path("data"),
    camera: Annotated[
        str, typer.Option(help="The camera: front, down, or another; for --sequence also several, comma-separated.")
    ] = "front",
    vehicle: VehicleName = None,
    size: Annotated[str | None, typer.Option(help="Pixels, WxH. Default: the camera's own.", metavar="WxH")] = None,
    write: Annotated[
        str,
        typer.Option(
            help="Outputs, comma-separated: rgb, depth, normals, instances, classes, parts, boxes, yolo, "
            "arrays, sonar, multibeam."
        ),
    ] = "rgb,depth,normals,instances,classes,boxes",
    pictures: Annotated[str, typer.Option(help="Format of rgb: png or jpg.")] = "png",
    effects: Annotated[str, typer.Option(help="on, off, or effects joined by +.")] = "on",
    without: Annotated[
        str, typer.Option(help="Effects to omit, such as wobble; for --sequence, instruments, such as multibeam.")
    ] = "",
    along: Annotated[
        Path | None,
        typer.Option(
            help="Take poses from a track: track-VEHICLE.csv of a run, track.npz of a survey, or your own.",
            callback=readable,
        ),
    ] = None,
    mission: Annotated[
        Path | None, typer.Option(help="Fly this mission first, and use its poses.", callback=readable)
    ] = None,
    sequence: Annotated[
        str | None,
        typer.Option(
            help="Fly this mission, and write a sequence for SLAM instead of single frames: all instruments at their "
            "rates in EuRoC's layout and as a ROS 1 bag, ground truth, calibration. Or the name of a packaged "
            "sequence, which also has baselines.",
            autocompletion=packaged("sequences"),
            callback=_readable_or_packaged,
        ),
    ] = None,
    time_limit: Annotated[
        float | None,
        typer.Option(help="End a --sequence after this simulated time [s].", callback=within(0.001, 1e7, "s")),
    ] = None,
    instruments: Annotated[
        str | None,
        typer.Option(help="Sensors and sonars of a --sequence, such as imu,dvl,multibeam. Default: all of them."),
    ] = None,
    no_bag: Annotated[bool, typer.Option("--no-bag", help="Write no ROS bag for a --sequence.")] = False,
    look_at: Annotated[
        str | None, typer.Option(help="Names or classes, comma-separated, such as gate,pipeline. Default: everything.")
    ] = None,
    distance: Annotated[
        str | None,
        typer.Option(help="Distance to the target [m], LOW..HIGH. Default: up to 0.6 of the water's visibility."),
    ] = None,
    clearance: Annotated[
        float | None,
        typer.Option(help="Free space around hull and camera [m]. Default: 0.2.", callback=within(0, 100, "m")),
    ] = None,
    pitch_max: Annotated[
        float | None,
        typer.Option(
            help="Largest pitch of the vehicle, up and down [deg]. Default: 15.", callback=within(0, 90, "deg")
        ),
    ] = None,
    roll_max: Annotated[
        float | None,
        typer.Option(
            help="Largest roll of the vehicle, to either side [deg]. Default: 5.", callback=within(0, 180, "deg")
        ),
    ] = None,
    vary: Vary = None,
    sonar: Annotated[str | None, typer.Option(help="The forward-looking sonar. Default: the first.")] = None,
    label_range: Annotated[
        float | None,
        typer.Option(
            help="Objects farther away have no labels [m]. Default: the water's visibility.",
            callback=within(0.01, 1e6, "m"),
        ),
    ] = None,
    min_pixels: Annotated[int, typer.Option(help="Smaller objects have no box.", callback=within(1, 1e9))] = 16,
    val_share: Annotated[float, typer.Option(help="Share of the frames for validation.", callback=within(0, 1))] = 0.2,
    empty_share: Annotated[
        float, typer.Option(help="Share of the frames without any object in the picture.", callback=within(0, 1))
    ] = 0.0,
    crowded_share: Annotated[
        float,
        typer.Option(
            help="Share of the frames with many: the pose that shows the most objects of 16.", callback=within(0, 1)
        ),
    ] = 0.0,
    seed: Seed = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    resume: Annotated[bool, typer.Option("--resume", help="Make the frames that are missing in --out.")] = False,
) -> None:
    """Create a dataset of labelled pictures.

    Writes colour, depth, normals, masks and boxes (COCO), sonar pictures with masks, and poses (transforms.json), split
    into training and validation sets. Poses are random, in open water with a target in view, or taken from a track. The
    bytes do not depend on the number of workers. Ctrl-C and kills lose only the frames in progress: --resume renders
    the rest. With --sequence, a mission is flown, and everything that the vehicle's instruments measure is written.
    """
    if sequence is not None and _is_packaged(sequence):
        _refuse_options(context, OF_NAMED, f"set by the sequence {sequence}; leave it out")
        _make_named_sequence(sequence, out, bag=not no_bag)
        return
    if scenario is None:
        raise UsageError("SCENARIO is missing: the name of a packaged scenario, or a YAML file")
    if sequence is not None:
        _refuse_options(context, OF_SEQUENCES, "for single frames; without effect with --sequence")
        _make_sequence(
            scenario, Path(sequence), out, cameras=_listed(camera), vehicle=vehicle, seed=seed, time_limit_s=time_limit,
            instruments=None if instruments is None else _listed(instruments), without=_listed(without), bag=not no_bag,
        )  # fmt: skip
        return
    need("--sequence", time_limit=time_limit, instruments=instruments, no_bag=no_bag or None)
    from uwsim.base.stoppable import stop_on_signals
    from uwsim.campaigns.datasets import make_dataset
    from uwsim.campaigns.workers.job_progress import job_progress

    options: dict[str, Any] = {
        "camera": camera,
        "vehicle": vehicle,
        "size": None if size is None else _size(size),
        "write": _listed(write),
        "pictures": pictures,
        "effects": effects if effects in ("on", "off") else tuple(effects.split("+")),
        "without": _listed(without),
        "sonar": sonar,
        "min_pixels": min_pixels,
        "val_share": val_share,
        "empty_share": empty_share,
        "crowded_share": crowded_share,
        "seed": seed,
        "label_range_m": label_range,
        "vary": dict(_variation(text) for text in vary or ()),
    }
    drawn = {
        "look_at": None if look_at is None else _listed(look_at),
        "distance_m": None if distance is None else _interval("--distance", distance),
        "clearance_m": clearance,
        "pitch_max_deg": pitch_max,
        "roll_max_deg": roll_max,
    }
    options |= {name: value for name, value in drawn.items() if value is not None}
    with job_progress("frames", "rendering") as progress, stop_on_signals(progress):
        made = make_dataset(
            scenario,
            out,
            n,
            along=along,
            mission=mission,
            workers=workers,
            scheduler=scheduler,
            resume=resume,
            stop_requested=progress.stop_requested,
            tell=progress.tell,
            show=progress.activity,
            **options,
        )
    _print(made)
    if made.interrupted:
        typer.echo(f"interrupted after {made.finished:,} of {made.spec.n:,} frames; --resume continues", err=True)
        raise typer.Exit(INTERRUPTED)


def _refuse_options(context: typer.Context, allowed: Collection[str], rule: str) -> None:
    """Raise WithoutEffectError for options that were passed and are not allowed."""
    passed = [
        "SCENARIO" if name == "scenario" else f"--{name.replace('_', '-')}"
        for name in context.params
        if name not in allowed and _is_passed(context, name)
    ]
    if passed:
        raise WithoutEffectError(f"{', '.join(passed)}: {rule}")


def _is_passed(context: typer.Context, name: str) -> bool:
    source = context.get_parameter_source(name)
    return source is not None and source.name == "COMMANDLINE"


def _make_sequence(scenario: str, mission: Path, out: Path, **options: Any) -> None:
    from uwsim.campaigns.datasets.sequences import make_sequence
    from uwsim.flight.terminal import Terminal

    _print_sequence(make_sequence(scenario, mission, out, screen=Terminal(), **options))


def _make_named_sequence(name: str, out: Path, *, bag: bool) -> None:
    from uwsim.campaigns.datasets.sequences.named import make_named_sequence
    from uwsim.flight.terminal import Terminal

    _print_sequence(made := make_named_sequence(name, out, bag=bag, screen=Terminal()))
    for baseline, errors in made.baselines.items():
        figures = ", ".join(f"{figure.removesuffix('_m')} {error_m:.3f} m" for figure, error_m in errors.items())
        typer.echo(f"{baseline:<10}{figures}")


def _print_sequence(made: Sequence) -> None:
    counts = ", ".join(f"{count:,} {name}" for name, count in made.counts.items())
    typer.echo(f"{made.flight.simulated_s:.1f} s in {made.out}: {counts}")


def _print(made: Dataset) -> None:
    typer.echo(f"{made.made:,} frames in {made.wall_s:.1f} s, {made.frames_per_s:.1f} frames/s")
    if made.files:
        typer.echo("  ".join(map(str, made.files)))


def _listed(text: str) -> tuple[str, ...]:
    return tuple(part.strip() for part in text.split(",") if part.strip())


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.lower().partition("x")
    if not (width.isdecimal() and height.isdecimal()):
        raise ValueError(f"--size {text}: must be WIDTHxHEIGHT in pixels, such as 320x240")
    return int(width), int(height)


def _interval(option: str, text: str) -> tuple[float, float]:
    low, dots, high = text.partition("..")
    try:
        if dots:
            return float(low), float(high)
    except ValueError:
        pass
    raise ValueError(f"{option} {text}: must be LOW..HIGH, such as 1..6")


def _variation(text: str) -> tuple[str, str]:
    """Parse --vary NAME=LOW..HIGH or NAME=A,B,C; return the name and the text of the variation."""
    name, _, values = text.partition("=")
    if not name or not values:
        raise ValueError(f"--vary {text}: must be NAME=LOW..HIGH or NAME=A,B,C")
    if ".." in values:
        _interval(f"--vary {name}", values)
    return name, values
