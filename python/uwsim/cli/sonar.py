"""`uwsim scenario sonar`: draw pictures of a vehicle's sonars from a pose."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwsim.cli.options import Pose, ScenarioName, SonarOptions, VehicleName
from uwsim.cli.values import one_of, within


def sonar(
    *,
    scenario: ScenarioName = "lake",
    vehicle: VehicleName = None,
    pose: Pose = None,
    out: Annotated[Path, typer.Option(help="The figure to write, a PNG.")] = Path("sonar.png"),
    kind: Annotated[
        str,
        typer.Option(
            help="fan (plan and section), image (forward-looking), side-scan, profile, or all; or water-column, of a "
            "multibeam in physics mode.",
            **one_of("fan", "image", "side-scan", "profile", "all", "water-column"),
        ),
    ] = "all",
    tilt: Annotated[
        float | None,
        typer.Option(
            help="Tilt of the head, nose down [deg]. Default: the scenario's for the fan, 12 for the image.",
            callback=within(-90, 90, "deg"),
        ),
    ] = None,
    track: Annotated[
        float,
        typer.Option(help="Length of the side-scan's track straight ahead [m].", callback=within(0.01, 1000, "m")),
    ] = 60.0,
    sonars: SonarOptions,
) -> None:
    """Draw what the sonars would see from a pose.

    Draws a fan over the true bed, a profile, a sonar image and a side-scan waterfall.
    """
    from uwsim.cli.draw_sonar import Request, run_sonar

    model, hertz = sonars.sonar, sonars.frequency_hz
    for line in run_sonar(Request(scenario, out, pose, kind, model, tilt, track, sonars.seed, hertz, vehicle)):
        typer.echo(line)
