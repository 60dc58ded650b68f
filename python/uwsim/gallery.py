"""Pictures side by side: what `uwsim camera` draws, and the sheet of waters, hours and lamps."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from uwsim.atomic_file import write_atomically
from uwsim.cameras import Camera, Frame, effects_on
from uwsim.pose_text import place_as_typed
from uwsim.simulator import Simulator

Image = NDArray[np.uint8]
SUFFIXES = (".png", ".jpg", ".jpeg")
GAP = 4
LONGEST_WAIT_S = 36_000.0  # minutes of computing


@dataclass(frozen=True)
class Wish:
    """What to take: which camera, from where, by which light.

    effects: one picture each: "on", "off", or names joined by "+". pose: X,Y,Z[,YAW[,PITCH[,ROLL]]] of the vehicle,
    metres and degrees, pitch down being positive; where it starts by default. lamps: names of the switches that are on.
    """

    camera: str = "front"
    effects: Sequence[str] = ("on", "off")
    pose: str | None = None
    jerlov: str | None = None
    sun_deg: float | None = None
    lamps: Sequence[str] = ()
    at_s: float = 0.0


def draw(scenario: str, wish: Wish, out: Path, *, seed: int | None = None, threads: int | None = None) -> list[Frame]:
    """Take the pictures, write them side by side to out (.png or .jpg, whole or not at all), return them.

    Raises ValueError for unknown names, malformed poses and places under the ground, OSError.
    """
    if out.suffix.lower() not in SUFFIXES:
        raise ValueError(f"out = {out}: must end in .png, .jpg or .jpeg")
    if not out.parent.is_dir():
        raise ValueError(f"out = {out}: no such folder: {out.parent}")
    choices = [effects_on(text if text in ("on", "off") else text.split("+")) for text in wish.effects]
    sim = Simulator(scenario, seed=seed, threads=threads)
    camera = set_up(sim, wish)
    frames = [camera.capture(choice) for choice in choices]
    write(out, side_by_side([[frame.rgb for frame in frames]]))
    return frames


def set_up(sim: Simulator, wish: Wish) -> Camera:
    """Bring vehicle, lamps, light and time to what was wished; return the camera. Raises ValueError."""
    cameras = {**sim.cameras, **sim.rov.cameras}
    if wish.camera not in cameras:
        raise ValueError(f"camera = {wish.camera!r}: must be one of {', '.join(cameras)}")
    for name in wish.lamps:
        if name not in sim.rov.lamps:
            raise ValueError(f"lamps = {name!r}: must be one of {', '.join(sim.rov.lamps) or 'none'}")
    for name, lamp in sim.rov.lamps.items():
        lamp.on = name in wish.lamps
    changes = {"jerlov": wish.jerlov, "sun_elevation_deg": wish.sun_deg}
    sim.set_optics(**{key: value for key, value in changes.items() if value is not None})
    if wish.pose is not None:
        place_as_typed(sim.rov, wish.pose)
    if not 0.0 <= wish.at_s <= LONGEST_WAIT_S:  # nan is not
        raise ValueError(f"at = {wish.at_s} s: must be in [0, {LONGEST_WAIT_S:g}] s")
    sim.advance(wish.at_s)
    return cameras[wish.camera]


def side_by_side(rows: Sequence[Sequence[Image]]) -> Image:
    """Rows of pictures of one size as one picture, with thin gaps."""
    height, width, _ = rows[0][0].shape
    columns = max(len(row) for row in rows)
    sheet = np.full((len(rows) * (height + GAP) - GAP, columns * (width + GAP) - GAP, 3), 255, np.uint8)
    for j, row in enumerate(rows):
        for i, image in enumerate(row):
            y, x = j * (height + GAP), i * (width + GAP)
            sheet[y : y + height, x : x + width] = image
    return sheet


def write(path: Path, image: Image, quality: int = 90) -> None:
    """Write a PNG or a JPEG, whole or not at all."""
    if path.suffix.lower() == ".png":
        from PIL import Image as Pillow

        stream = io.BytesIO()
        Pillow.fromarray(image).save(stream, "PNG", optimize=True)
        data = stream.getvalue()
    else:
        import simplejpeg

        data = bytes(simplejpeg.encode_jpeg(np.ascontiguousarray(image), quality=quality))
    write_atomically(path, data)
