"""Draw docs/guides/scenes.jpg, scenarios from their views, and course.jpg, the course from four places."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from uwsim import Simulator
from uwsim.base.quaternions import of_yaw_pitch_roll_deg

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "guides"
SIZE, FINE = (400, 225), 2
NAMES = ("reef", "wreck", "kelp", "harbour", "wind_farm", "fish_farm", "lake", "tarn", "training_pool")
PLACES = ((-9.5, -0.8, -1.0, 5, 3), (-3.6, 0.2, -1.3, 8, 2), (3.5, -1, -1.3, 10, 3), (4.4, 3.4, -1.2, 22, 0))
"""In the course: x, y, z [m], heading and how far down [deg]."""


def main() -> None:
    """Write the pictures."""
    views = []
    for name in NAMES:
        with Simulator(name) as sim:
            view = sim.scenario.view
            assert view is not None
            views.append(seen(sim, view.position_m, (view.yaw_deg, view.pitch_deg, 0.0)))
    save("scenes.jpg", views, columns=3)
    with Simulator("course") as sim:
        save("course.jpg", [seen(sim, place[:3], (*place[3:], 0.0)) for place in PLACES], columns=2)


def seen(sim: Simulator, position_m: tuple[float, ...], turn_deg: tuple[float, float, float]) -> NDArray[np.uint8]:
    """Return what the front camera sees."""
    sim.rov.release()
    sim.rov.place(position_m, of_yaw_pitch_roll_deg(turn_deg))
    fine = sim.rov.cameras["front"].resized(FINE * SIZE[0], FINE * SIZE[1]).capture()
    return np.asarray(Image.fromarray(fine.rgb).resize(SIZE, Image.Resampling.LANCZOS))


def save(name: str, pictures: list[NDArray[np.uint8]], columns: int) -> None:
    """Save pictures beside and below each other."""
    rows = [np.hstack(pictures[k : k + columns]) for k in range(0, len(pictures), columns)]
    Image.fromarray(np.vstack(rows)).save(FOLDER / name, quality=82)


if __name__ == "__main__":
    main()
