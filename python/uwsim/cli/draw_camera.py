"""Drawing for `uwsim scenario camera`: pictures from one camera with different effects, side by side in one file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from uwsim.cli.pose_option import chosen_vehicle, place_as_typed
from uwsim.figures.contact_sheet import contact_sheet
from uwsim.instruments.cameras import Camera, Frame
from uwsim.instruments.cameras.effects import effects_on
from uwsim.instruments.cameras.image_file import check_suffix, write_image
from uwsim.simulator.simulator import Simulator

LONGEST_WAIT_S = 36_000.0  # takes minutes of wall time


@dataclass(frozen=True)
class CameraRequest:
    """The camera of a picture, its pose and its light.

    effects: one entry per picture: "on", "off", or names joined by "+". pose: the vehicle's X,Y,Z[,YAW[,PITCH[,ROLL]]]
    in metres and degrees, positive pitch is down; by default the scenario's view, of the first vehicle, or its start.
    lamps: names of the switches to turn on. at_s:
    the simulated time. vehicle: its name; by default the first.
    """

    camera: str = "front"
    effects: Sequence[str] = ("on", "off")
    pose: str | None = None
    jerlov: str | None = None
    sun_deg: float | None = None
    lamps: Sequence[str] = ()
    at_s: float = 0.0
    vehicle: str | None = None


def draw(
    scenario: str, request: CameraRequest, out: Path, *, seed: int | None = None, threads: int | None = None
) -> list[Frame]:
    """Capture the pictures, write them side by side to out (.png or .jpg, atomically) and return them.

    Raises OSError, and ValueError for unknown names, malformed poses and positions below the ground.
    """
    check_suffix("out", out)
    if not out.parent.is_dir():
        raise ValueError(f"out = {out}: no such folder: {out.parent}")
    choices = [effects_on(text if text in ("on", "off") else text.split("+")) for text in request.effects]
    sim = Simulator(scenario, seed=seed, threads=threads)
    camera = set_up(sim, request)
    frames = [camera.capture(choice) for choice in choices]
    write_image(out, contact_sheet([[frame.rgb for frame in frames]]), optimize=True)
    return frames


def set_up(sim: Simulator, request: CameraRequest) -> Camera:
    """Set lamps, light, pose and time as requested, and return the camera. Raises ValueError."""
    rov = chosen_vehicle(sim, request.vehicle)
    cameras = {**sim.cameras, **rov.cameras}
    if request.camera not in cameras:
        raise ValueError(f"camera = {request.camera!r}: must be one of {', '.join(cameras)}")
    for name in request.lamps:
        if name not in rov.lamps:
            raise ValueError(f"lamps = {name!r}: must be one of {', '.join(rov.lamps) or 'none'}")
    for name, lamp in rov.lamps.items():
        lamp.on = name in request.lamps
    if request.jerlov is not None:
        sim.set_optics(jerlov=request.jerlov)
    if request.sun_deg is not None:
        sim.set_optics(sun_elevation_deg=request.sun_deg)
    pose = _view_of(sim) if request.pose is None and rov is sim.rov else request.pose
    if pose is not None:
        place_as_typed(rov, pose)
    if not 0.0 <= request.at_s <= LONGEST_WAIT_S:  # also false for NaN
        raise ValueError(f"at = {request.at_s} s: must be in [0, {LONGEST_WAIT_S:g}] s")
    sim.advance(request.at_s)
    if pose is not None and request.at_s:
        place_as_typed(rov, pose)  # again, since the vehicle may have drifted
    return cameras[request.camera]


def _view_of(sim: Simulator) -> str | None:
    view = sim.scenario.view
    return None if view is None else ",".join(f"{part!r}" for part in (*view.position_m, view.yaw_deg, view.pitch_deg))
