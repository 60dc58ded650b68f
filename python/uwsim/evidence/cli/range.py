"""`uwsim range`: certify what instruments can do in given waters."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwsim.cli.bounds import UsageError, within
from uwsim.cli.choices import one_of
from uwsim.cli.groups import under
from uwsim.cli.options import ScenarioName


@under("Check")
def range_(
    what: Annotated[str, typer.Argument(help="What to certify: vision.", **one_of("vision"))] = "vision",
    scenario: ScenarioName = "reef",
    out: Annotated[Path, typer.Option(help="Folder for vision.md and vision.json.")] = Path("range"),
    seeds: Annotated[int, typer.Option(help="Legs per condition.", callback=within(1, 100))] = 2,
    first_seed: Annotated[
        int, typer.Option(help="The first leg's seed; keep some for the end.", callback=within(0, 10**6))
    ] = 1,
    frames: Annotated[
        int, typer.Option(help="Stereo pairs per leg, 5 per second at 0.5 m/s.", callback=within(3, 1000))
    ] = 30,
    conditions: Annotated[
        str | None, typer.Option(help="Some of sun, overcast, low sun, coastal, murky, night; comma-separated.")
    ] = None,
    pictures: Annotated[
        bool, typer.Option("--pictures", help="Keep pictures, calibration and true poses for other programs.")
    ] = False,
    orbit: Annotated[
        int, typer.Option(help="Pictures of an orbit for COLMAP (pycolmap); 0: none.", callback=within(0, 500))
    ] = 0,
    score: Annotated[
        Path | None,
        typer.Option(help="Fly nothing: judge each estimated.txt (as TUM's) beside a truth.txt in this folder."),
    ] = None,
) -> None:
    """Certify how well cameras navigate, and what takes it from them.

    Flies straight legs 2 m over the bed in sun, under cloud, in three waters and by lamps, with a stereo camera, and
    judges tracks that stay, stereo matches, and odometry by ORB features against the truth; with --orbit, also how much
    of a circle COLMAP joins, and the error of its path. Each is flown again
    without focused light, motion, turbidity or the sensor's noise: what is better then is what they take.
    """
    from uwsim.evidence.vision.colmap import is_installed
    from uwsim.evidence.vision.folder import keep, scored
    from uwsim.evidence.vision.sequence import shots
    from uwsim.evidence.vision.suite import CONDITIONS, flown, write

    if score is not None:
        for each in scored(score):
            typer.echo(
                f"{each.folder}: {each.complete:.0%} of the pictures, {each.rms_m:.3f} m rms, drift {each.drift:.1%}"
            )
        return
    names = [part.strip() for part in conditions.split(",")] if conditions is not None else [c.name for c in CONDITIONS]
    known = {condition.name: condition for condition in CONDITIONS}
    for name in names:
        if name not in known:
            raise UsageError(f"--conditions {name}: must be some of {', '.join(known)}")
    chosen, numbers = [known[name] for name in names], list(range(first_seed, first_seed + seeds))
    out.mkdir(parents=True, exist_ok=True)
    if pictures:
        for condition in chosen:
            for seed in numbers:
                keep(
                    folder := out / condition.name.replace(" ", "_") / str(seed),
                    list(shots(scenario, condition, seed, frames)),
                )
                typer.echo(str(folder))
    if orbit and not is_installed():
        typer.echo("COLMAP is left out: pip install pycolmap", err=True)
        orbit = 0
    rows = flown(scenario, numbers, frames, chosen, typer.echo, orbit)
    for path in write(out, rows, scenario, numbers, frames):
        typer.echo(str(path))
