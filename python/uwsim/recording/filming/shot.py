"""Shot: one frame of a film, rendered by a worker as the mean of many pictures in linear light."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arrays import Floats
from uwsim.base.atomic_file import write_atomically
from uwsim.base.quaternions import of_yaw_pitch_roll_deg, product
from uwsim.instruments.cameras.camera import Camera
from uwsim.instruments.cameras.image_file import encode_png
from uwsim.instruments.cameras.shared_scene import SharedScene, Snapshot
from uwsim.recording.filming.roll import scene_of
from uwsim.recording.reader import Recording
from uwsim.recording.replay import new_simulator
from uwsim.scenario.spec.camera import CameraMount

SHUTTER = 0.5
"""Share of the time between frames for which the shutter is open."""
SUN_DEG = 0.265
"""Angular radius of the sun's disc, from which light comes: shadows have soft edges."""
R2 = np.array([0.7548776662466927, 0.5698402909980532])
"""Steps of a sequence that fills the unit square evenly (Roberts 2018, "The unreasonable effectiveness of quasirandom
sequences")."""
WITHOUT = ("noise", "vignetting", "shutter")
"""Effects of a small camera, which a film's does without."""


@dataclass(frozen=True, eq=False)
class Shot:
    """A frame to render.

    recording: file whose scenario is shown. path: the picture to write. states: at this frame and at the next. poses:
    (2, 7), the camera's at these times. mount: its lens. hidden: index of a vehicle that does not appear, or None.
    gain: exposure. samples: number of pictures of which the frame is the mean.
    """

    recording: str
    path: str
    states: tuple[Snapshot, Snapshot]
    poses: Floats
    mount: CameraMount
    hidden: int | None
    gain: float
    samples: int
    threads: int | None


class FilmCamera(Camera):
    """A camera at a fixed pose that leaves out one vehicle, whose camera it stands for."""

    def __init__(self, mount: CameraMount, scene: SharedScene, pose: Floats, hidden: int | None) -> None:
        super().__init__("film", mount, scene, (pose[:3], pose[3:]))
        self.__dict__["_hidden"] = hidden

    @property
    def hidden(self) -> int | None:
        """See Camera."""
        hidden: int | None = self.__dict__["_hidden"]
        return hidden


def shoot(shot: Shot) -> dict[str, Any]:
    """Render a frame and write it; return the digest of its colours. Raises OSError."""
    light = np.zeros((shot.mount.height, shot.mount.width, 3))
    scene = _stage(shot.recording, Path(shot.recording).stat().st_mtime_ns, shot.threads)
    for k in range(shot.samples):
        light += _picture(shot, scene, k)
    rgb = developed(light / shot.samples * shot.gain)
    write_atomically(Path(shot.path), encode_png(rgb))
    return {"error": None, "picture": hashlib.blake2b(rgb.tobytes(), digest_size=8).hexdigest()}


def developed(linear: Floats) -> NDArray[np.uint8]:
    """Return 8-bit sRGB (IEC 61966-2-1) of linear light, 1 for white."""
    x = np.clip(linear, 0.0, 1.0)
    encoded = np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
    return (encoded * 255.0 + 0.5).astype(np.uint8)


def between(states: tuple[Snapshot, Snapshot], share: float) -> Snapshot:
    """Return the state at a share of the time between two."""
    one, two = states
    mixed = (1 - share) * one.orientations_xyzw + share * _nearest(two.orientations_xyzw, one.orientations_xyzw)
    return replace(
        one,
        time_ns=round((1 - share) * one.time_ns + share * two.time_ns),
        positions_m=(1 - share) * one.positions_m + share * two.positions_m,
        orientations_xyzw=mixed / np.linalg.norm(mixed, axis=-1, keepdims=True),
    )


def _picture(shot: Shot, scene: SharedScene, k: int) -> Floats:
    """Return the radiance (H, W, 3) of sample k, with a time and a place in the pixels and on the sun of its own."""
    across, down = np.mod(0.5 + k * R2, 1.0) - 0.5
    share = SHUTTER * (k + 0.5) / shot.samples
    state = between(shot.states, share)
    position = (1 - share) * shot.poses[0, :3] + share * shot.poses[1, :3]
    turn = (1 - share) * shot.poses[0, 3:] + share * _nearest(shot.poses[1, 3:], shot.poses[0, 3:])
    turn = np.asarray(turn / np.linalg.norm(turn))
    pixel_deg = np.degrees(2 * np.tan(np.radians(0.5 * shot.mount.field_of_view_deg)) / shot.mount.width)
    if shot.samples > 1:
        turn = product(turn, of_yaw_pitch_roll_deg((float(across * pixel_deg), float(down * pixel_deg), 0.0)))
        optics = state.optics
        elevation = float(np.clip(optics.sun_elevation_deg + 2 * SUN_DEG * down, -6.0, 90.0))
        azimuth = optics.sun_azimuth_deg + 2 * SUN_DEG * across
        changed = {"sun_elevation_deg": elevation, "sun_azimuth_deg": float(azimuth)}
        state = replace(state, optics=optics.model_copy(update=changed))
    camera = FilmCamera(shot.mount, scene, np.concatenate([position, turn]), shot.hidden)
    frame = camera.capture(without=WITHOUT, radiance=True, at=state, threads=shot.threads, dark_below_ground=True)
    return np.asarray(frame.radiance, np.float64)


def _nearest(turns: Floats, to: Floats) -> Floats:
    """Return unit quaternions (..., 4) with the signs that are nearer to others."""
    return np.asarray(np.where((turns * to).sum(axis=-1, keepdims=True) < 0, -turns, turns))


@lru_cache(maxsize=1)
def _stage(recording: str, modified_ns: int, threads: int | None) -> SharedScene:
    """Return the scene of a recording's scenario."""
    sim = new_simulator(Recording(recording), threads)
    scene = scene_of(sim)
    scene.__dict__["simulator"] = sim  # whose files live as long as it does
    return scene
