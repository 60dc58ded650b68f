"""Makes docs/cameras.jpg: the ROV's cameras and the station's, by waters, hours and lamps. Needs the package built."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image
from scipy.spatial.transform import Rotation

from uwsim import Simulator
from uwsim.gallery import side_by_side, write
from uwsim.scenario import load

DOCS = Path(__file__).resolve().parents[2] / "docs"
WATERS = ("I", "III", "5C", "9C")
NOON_DEG, DUSK_DEG = 60.0, 1.0
THUMB = (240, 135)
BESIDE_PIPE = (-72.0, -23.6, 1.5, 22.0)  # x, y, height above the bed, yaw [deg]


def put_beside_the_pipe(sim: Simulator) -> None:
    """Hover over the bed, looking along the pipeline."""
    x, y, above, yaw = BESIDE_PIPE
    bed = float(sim.world.height_at([[x, y]])[0])
    sim.rov.place((x, y, bed + above), Rotation.from_euler("z", yaw, degrees=True).as_quat())


def take(sim: Simulator, camera: str, jerlov: str, sun_deg: float, *, lamps: bool, effects: str = "on") -> np.ndarray:
    """One thumbnail."""
    sim.set_optics(jerlov=jerlov, sun_elevation_deg=sun_deg)
    for lamp in sim.rov.lamps.values():
        lamp.on = lamps
    cameras = {**sim.cameras, **sim.rov.cameras}
    image = Image.fromarray(cameras[camera].capture(effects).rgb)
    return np.asarray(image.resize(THUMB, Image.Resampling.LANCZOS))


def main() -> None:
    """Draw and write the sheet."""
    lake = load("lake")
    shallow = lake.terrain.model_copy(update={"bed_depth_m": 9.0, "hill_height_m": 3.0})  # that noon may reach its bed
    sim = Simulator(lake.model_copy(update={"terrain": shallow}))
    sim.rov.release()
    put_beside_the_pipe(sim)
    rows = []
    for camera in ("front", "down"):
        rows.append([take(sim, camera, water, NOON_DEG, lamps=False) for water in WATERS])
        rows.append([take(sim, camera, water, DUSK_DEG, lamps=True) for water in WATERS])
    rows.append(
        [
            take(sim, "front", "III", NOON_DEG, lamps=False, effects="off"),
            take(sim, "front", "III", DUSK_DEG, lamps=False),
            take(sim, "station", "III", NOON_DEG, lamps=False),
            take(sim, "station", "III", DUSK_DEG, lamps=False),
        ]
    )
    write(DOCS / "cameras.jpg", side_by_side(rows))


if __name__ == "__main__":
    main()
