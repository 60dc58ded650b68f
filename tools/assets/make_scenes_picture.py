"""Draw docs/guides/scenes.jpg, a picture of scenarios from their views, by daylight. Needs the built package."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from uwsim import Simulator
from uwsim.base.quaternions import of_yaw_pitch_roll_deg

OUT = Path(__file__).resolve().parents[2] / "docs" / "guides" / "scenes.jpg"
SIZE, FINE = (400, 225), 2
NAMES = ("reef", "wreck", "kelp", "harbour", "wind_farm", "fish_farm", "lake", "tarn", "training_pool")
COLUMNS = 3


def main() -> None:
    """Write the picture."""
    pictures = []
    for name in NAMES:
        with Simulator(name) as sim:
            sim.rov.release()
            view = sim.scenario.view
            sim.rov.place(view.position_m, of_yaw_pitch_roll_deg((view.yaw_deg, view.pitch_deg, 0.0)))
            fine = sim.rov.cameras["front"].resized(FINE * SIZE[0], FINE * SIZE[1]).capture()
            pictures.append(np.asarray(Image.fromarray(fine.rgb).resize(SIZE, Image.Resampling.LANCZOS)))
    rows = [np.hstack(pictures[k : k + COLUMNS]) for k in range(0, len(pictures), COLUMNS)]
    Image.fromarray(np.vstack(rows)).save(OUT, quality=82)


if __name__ == "__main__":
    main()
