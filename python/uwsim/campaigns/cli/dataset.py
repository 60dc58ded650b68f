"""`uwsim dataset`: labelled camera and sonar images, for machine learning."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from uwsim.base.named import did_you_mean
from uwsim.base.options import Options, WithoutEffectError, flag_name, is_given, option
from uwsim.campaigns.workers.options import CampaignOptions
from uwsim.cli.exit_codes import INTERRUPTED
from uwsim.cli.flags import ModelFlags
from uwsim.cli.groups import under
from uwsim.cli.values import UsageError, packaged_folder, readable, require_file, scenarios

if TYPE_CHECKING:
    from uwsim.campaigns.datasets import Dataset
    from uwsim.campaigns.datasets.sequences import Sequence

OF_SEQUENCES = ("scenario", "camera", "vehicle", "seed", "without")
"""The other options that have an effect on a sequence."""


class FrameFlags(ModelFlags):
    """The flags of single frames."""

    model = "uwsim.campaigns.datasets.spec:DatasetSpec"
    others = ("scenario",)


@dataclass(frozen=True)
class SequenceOptions(Options):
    """The options of a sequence for SLAM."""

    switch = "sequence"

    sequence: str | None = option(
        None,
        "Fly this mission, and write a sequence for SLAM instead of single frames: all instruments at their rates in "
        "EuRoC's layout and as a ROS 1 bag, ground truth, calibration. Or the name of a packaged sequence, which also "
        "has baselines.",
        completion="sequences",
    )
    time_limit_s: float | None = option(
        None, "End a --sequence after this simulated time [s].", bounds=(0.001, 1e7, "s")
    )
    instruments: str | None = option(
        None, "Sensors and sonars of a --sequence, such as imu,dvl,multibeam. Default: all of them."
    )
    no_bag: bool = option(False, "Write no ROS bag for a --sequence.")


def _is_packaged(sequence: str) -> bool:
    """Return whether this names a packaged sequence; a mission's file of the same name comes first."""
    if Path(sequence).exists():
        require_file(Path(sequence), "--sequence")
        return False
    known = sorted(path.stem for path in (packaged_folder("assets", "assets") / "sequences").glob("*.yaml"))
    if sequence not in known:
        rule = f"must be a mission's file, or one of {', '.join(known)}{did_you_mean(sequence, known)}"
        raise UsageError(f"--sequence = '{sequence}': {rule}")
    return True


@under("Fly")
def dataset(
    *,
    scenario: Annotated[
        str | None,
        typer.Argument(
            help="Name of a packaged scenario, or path of a YAML file; none for a named --sequence.",
            autocompletion=scenarios,
            show_default=False,
        ),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for the pictures and their tables.")] = Path("data"),
    frames: FrameFlags,
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
    sequences: SequenceOptions,
    work: CampaignOptions,
) -> None:
    """Create a dataset of labelled pictures.

    Writes colour, depth, normals, masks and boxes (COCO), sonar pictures with masks, and poses, split
    into training and validation sets. Poses are random, in open water with a target in view, or taken from a track. The
    bytes do not depend on the number of workers. Ctrl-C and kills lose only the frames in progress: --resume renders
    the rest. With --sequence, a mission is flown, and everything that the vehicle's instruments measure is written.
    """
    given = frames.arguments
    if sequences.sequence is not None:
        is_packaged = _is_packaged(sequences.sequence)
        others = {"scenario": scenario, **given, "along": along, "mission": mission, **work.arguments}
        if is_packaged:
            others |= {"time_limit_s": sequences.time_limit_s, "instruments": sequences.instruments}
            _refuse(f"set by the sequence {sequences.sequence}; leave it out", others)
            _make_named_sequence(sequences.sequence, out, bag=not sequences.no_bag)
            return
        others = {name: value for name, value in others.items() if name not in OF_SEQUENCES}
        _refuse("for single frames; without effect with --sequence", others)
    if scenario is None:
        raise UsageError("SCENARIO is missing: the name of a packaged scenario, or a YAML file")
    if sequences.sequence is not None:
        chosen = {"instruments": _listed(sequences.instruments)} if sequences.instruments is not None else {}
        _make_sequence(
            scenario, Path(sequences.sequence), out, cameras=_listed(given.get("camera", "front")),
            vehicle=given.get("vehicle"), seed=given.get("seed"), time_limit_s=sequences.time_limit_s,
            without=_listed(given.get("without", "")), bag=not sequences.no_bag, **chosen,
        )  # fmt: skip
        return
    from uwsim.campaigns.datasets import make_dataset
    from uwsim.campaigns.workers.job_progress import job_progress

    with job_progress("frames", "rendering") as progress:
        options = {"n": 100} | given | work.arguments | progress.arguments
        made = make_dataset(scenario, out, along=along, mission=mission, **options)
    _print(made)
    if made.interrupted:
        typer.echo(f"interrupted after {made.finished:,} of {made.spec.n:,} frames; --resume continues", err=True)
        raise typer.Exit(INTERRUPTED)


def _refuse(rule: str, options: dict[str, Any]) -> None:
    names = ["SCENARIO" if name == "scenario" else flag_name(name) for name in options if is_given(options[name])]
    if names:
        raise WithoutEffectError(f"{', '.join(names)}: {rule}")


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
