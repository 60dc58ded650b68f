"""Draw docs/guides/scenes.jpg, a picture of each scenario with cover, by daylight. Needs the built package."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from uwsim import Simulator
from uwsim.base.quaternions import of_yaw_pitch_roll_deg

OUT = Path(__file__).resolve().parents[2] / "docs" / "guides" / "scenes.jpg"
SIZE, FINE = (400, 225), 2
VIEWS = {  # x, y, z, yaw and pitch [deg], of the vehicle
    "reef": (-8.0, -6.0, -6.2, 50.0, 18.0),
    "wreck": (-9.5, -11.5, -11.0, 48.0, -4.0),
    "kelp": (-8.0, -8.0, -9.5, 45.0, -5.0),
    "harbour": (-8.0, 16.0, -3.5, 92.0, 8.0),
    "wind_farm": (14.0, -1.0, -22.0, 135.0, 35.0),
    "fish_farm": (-9.0, -8.4, -4.2, 90.0, 0.0),
}
COLUMNS = 3


def main() -> None:
    """Write the picture."""
    pictures = []
    for name, (x, y, z, yaw, pitch) in VIEWS.items():
        with Simulator(name) as sim:
            sim.rov.release()
            sim.rov.place((x, y, z), of_yaw_pitch_roll_deg((yaw, pitch, 0.0)))
            fine = sim.rov.cameras["front"].resized(FINE * SIZE[0], FINE * SIZE[1]).capture()
            pictures.append(np.asarray(Image.fromarray(fine.rgb).resize(SIZE, Image.Resampling.LANCZOS)))
    rows = [np.hstack(pictures[k : k + COLUMNS]) for k in range(0, len(pictures), COLUMNS)]
    Image.fromarray(np.vstack(rows)).save(OUT, quality=82)


if __name__ == "__main__":
    main()
