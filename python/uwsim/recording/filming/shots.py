"""shots_of: the frames of a film, with where its camera is and how bright its pictures are."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter1d

from uwsim.base.arrays import Floats
from uwsim.recording.filming import views
from uwsim.recording.filming.options import QUALITIES, FilmOptions
from uwsim.recording.filming.roll import Roll, scene_of
from uwsim.recording.filming.shot import WITHOUT, FilmCamera, Shot
from uwsim.scenario.spec.camera import CameraMount

FOV_DEG = 75.0
METERED_S, METERED_PIXELS, STEADY_S = 0.2, 96, 1.0
"""Exposure: time between its measurements, their width, and the standard deviation of the Gaussian that steadies it."""


def shots_of(recording: Path, roll: Roll, folder: Path, wanted: FilmOptions, threads: int | None) -> list[Shot]:
    """Return the frames of a roll, whose pictures are to be in a folder. Raises ValueError or OSError.

    wanted: camera, size, rate and quality.
    """
    view, fps, size, samples = wanted.camera, wanted.fps, wanted.pixels, QUALITIES[wanted.quality]
    positions = np.array([state.positions_m[roll.vehicle] for state in roll.states])
    lens: dict[str, Any] = {"width": size[0], "height": size[1]}
    mount, hidden = CameraMount(position_m=(0.0, 0.0, 0.0), field_of_view_deg=FOV_DEG, **lens), None
    if roll.camera is not None:
        level = {"position_m": (0.0, 0.0, 0.0), "yaw_pitch_roll_deg": (0.0, 0.0, 0.0), "follows": "body"}
        mount = roll.camera.mount.resized(*size).model_copy(update={**level, "pan_tilt": None, "on": True})
        hidden, poses = roll.camera.hidden, roll.poses
    elif view == "chase":
        turns = np.array([state.orientations_xyzw[roll.vehicle] for state in roll.states])
        poses = views.chase(roll.sim, positions, turns, fps)
    elif view == "orbit":
        poses = views.orbit(roll.sim, positions, fps)
    else:
        poses = views.along_path(Path(view), np.array([1e-9 * state.time_ns for state in roll.states]))
    gains = _gains(roll, poses, mount, hidden, fps)
    return [
        Shot(
            str(recording.resolve()), str((folder / f"{k:06d}.png").resolve()), (roll.states[k], roll.states[k + 1]),
            poses[k : k + 2], mount, hidden, float(gains[k]), samples, threads,
        )
        for k in range(len(roll.states) - 1)
    ]  # fmt: skip


def _gains(roll: Roll, poses: Floats, mount: CameraMount, hidden: int | None, fps: float) -> Floats:
    """Return a steady exposure for each frame, from small pictures of some."""
    every = max(round(METERED_S * fps), 1)
    small = mount.resized(METERED_PIXELS, max(METERED_PIXELS * mount.height // mount.width, 1))
    scene = scene_of(roll.sim)
    at = np.arange(0, len(poses), every)
    seen = [
        FilmCamera(small, scene, poses[k], hidden)
        .capture(without=WITHOUT, at=roll.states[k], dark_below_ground=True)
        .gain
        for k in at
    ]
    return np.asarray(np.exp(np.interp(
        np.arange(len(poses)), at, gaussian_filter1d(np.log(seen), STEADY_S / METERED_S, mode="nearest")
    )))  # fmt: skip
