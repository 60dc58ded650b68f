"""Draw docs/guides/cameras.jpg, the contact sheet of docs/guides/cameras.md.

It shows pictures of the ROV's front and down cameras in several waters, at noon without lamps and at dusk with lamps.
Further pictures are of the front camera without any effects and with warm and cold water mixing in front of it, of the
ROV from its chase camera, and of the ROV in its cage from the station's camera. The layout is in
figures/contact_sheet.py. Needs the built package.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image
from scipy.spatial.transform import Rotation

from uwsim import Simulator
from uwsim.figures.contact_sheet import contact_sheet
from uwsim.scenario import load

OUT = Path(__file__).resolve().parents[2] / "docs" / "guides" / "cameras.jpg"
WATERS = ("I", "III", "5C", "9C")
NOON_DEG, DUSK_DEG = 60.0, 1.0
TURBULENT_K = 8.0  # far more than natural mixing causes, to be visible in a small image
THUMBNAIL = (240, 135)
BESIDE_PIPE = (-72.0, -23.6, 1.5, 22.0)  # x, y, height above the bed, yaw [deg]


def hover_beside_the_pipeline(sim: Simulator) -> None:
    """Place the ROV above the bed, looking along the pipeline."""
    x, y, above, yaw = BESIDE_PIPE
    bed = float(sim.world.height_at([[x, y]])[0])
    sim.rov.place((x, y, bed + above), Rotation.from_euler("z", yaw, degrees=True).as_quat())


def thumbnail(
    sim: Simulator,
    camera: str,
    jerlov: str,
    sun_deg: float,
    *,
    lamps: bool,
    effects: str = "on",
    turbulence_k: float = 0.5,
) -> np.ndarray:
    """Capture one image and downscale it."""
    sim.set_optics(jerlov=jerlov, sun_elevation_deg=sun_deg, turbulence_k=turbulence_k)
    for lamp in sim.rov.lamps.values():
        lamp.on = lamps
    cameras = {**sim.cameras, **sim.rov.cameras}
    image = Image.fromarray(cameras[camera].capture(effects).rgb)
    return np.asarray(image.resize(THUMBNAIL, Image.Resampling.LANCZOS))


def main() -> None:
    """Draw the contact sheet and write it."""
    lake = load("lake")
    shallow = lake.terrain.model_copy(update={"bed_depth_m": 9.0, "hill_height_m": 3.0})  # lit down to the bed at noon
    waters = lake.optics.model_copy(update={"visibility_m": None})  # as clear as each water type
    sim = Simulator(lake.model_copy(update={"terrain": shallow, "optics": waters}))
    at_the_station = thumbnail(sim, "station", "IB", NOON_DEG, lamps=True)
    sim.rov.release()
    hover_beside_the_pipeline(sim)
    rows = []
    for camera in ("front", "down"):
        rows.append([thumbnail(sim, camera, water, NOON_DEG, lamps=False) for water in WATERS])
        rows.append([thumbnail(sim, camera, water, DUSK_DEG, lamps=True) for water in WATERS])
    rows.append(
        [
            thumbnail(sim, "front", "III", NOON_DEG, lamps=False, effects="off"),
            thumbnail(sim, "front", "III", NOON_DEG, lamps=False, turbulence_k=TURBULENT_K),
            thumbnail(sim, "chase", "III", NOON_DEG, lamps=True),
            at_the_station,
        ]
    )
    Image.fromarray(contact_sheet(rows)).save(OUT, quality=90)


if __name__ == "__main__":
    main()
