"""`uwsim scenario camera`: capture pictures with a camera of the scenario."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from uwsim.cli.options import Pose, ScenarioName, Seed, Threads, VehicleName
from uwsim.cli.values import one_of, within


def camera(
    scenario: ScenarioName = "lake",
    out: Annotated[Path, typer.Option(help="The picture to write: .png or .jpg.")] = Path("camera.png"),
    effects: Annotated[
        str, typer.Option(help="Pictures side by side, comma-separated; each is on, off, or effects joined by +.")
    ] = "on",
    name: Annotated[
        str, typer.Option("--camera", help="The camera: front, down, chase, station, or another.")
    ] = "front",
    vehicle: VehicleName = None,
    pose: Pose = None,
    jerlov: Annotated[
        str | None,
        typer.Option(
            help="Water type: I, IA, IB, II, III, 1C, 3C, 5C, 7C, 9C.",
            **one_of("I", "IA", "IB", "II", "III", "1C", "3C", "5C", "7C", "9C"),
        ),
    ] = None,
    sun: Annotated[
        float | None, typer.Option(help="Elevation of the sun [deg].", callback=within(-6, 90, "deg"))
    ] = None,
    lamps: Annotated[str, typer.Option(help="Lamps to switch on, comma-separated: front, down.")] = "",
    at: Annotated[
        float, typer.Option(help="Simulated time at which to capture [s].", callback=within(0, 36_000, "s"))
    ] = 0.0,
    calibration: Annotated[
        Path | None,
        typer.Option(help="Write its calibration, too: .yaml as ROS's camera_info, .yml as OpenCV's FileStorage."),
    ] = None,
    seed: Seed = None,
    threads: Threads = None,
) -> None:
    """Capture pictures with and without the water's effects."""
    from uwsim.cli.draw_camera import CameraRequest, draw
    from uwsim.scenario.read.calibration import check_suffix, write_calibration

    wanted = [part for part in effects.split(",") if part]
    if not wanted:
        raise ValueError(f"effects = {effects!r}: must name at least one picture")
    if calibration is not None:
        check_suffix(calibration)
    request = CameraRequest(name, wanted, pose, jerlov, sun, [part for part in lamps.split(",") if part], at, vehicle)
    frames = draw(scenario, request, out, seed=seed, threads=threads)
    typer.echo(f"{out}: {len(frames)} x {frames[0].info.width} x {frames[0].info.height} pixels, camera '{name}'")
    if calibration is not None:
        write_calibration(calibration, frames[0].info, name)
        typer.echo(f"{calibration}: calibration of camera '{name}'")
