"""The patterns of materials belong to the world: they do not change where the frame of textures repeats."""

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.scenario import Scenario
from uwsim.scenario.read.validated import validated

REPEAT_M = 256.0


@pytest.fixture(scope="module")
def plain() -> Simulator:
    spec = {
        "name": "plain",
        "terrain": {"source": "noise", "size_m": [1200, 1200], "spacing_m": 20, "bed_depth_m": 6, "hill_height_m": 0},
        "vehicles": [{"name": "rov", "model": "rov", "start": {"position_m": [30, 30, -4]}}],
    }
    return Simulator(validated(Scenario, spec))


def picture(sim: Simulator, x_m: float, y_m: float) -> np.ndarray:
    """Return a picture of the bed below a camera at (x, y), by daylight alone."""
    half, camera = np.pi / 4, sim.rov.cameras["front"].resized(96, 72)
    place, turn = np.array([x_m, y_m, -4.5]), np.array([0, np.sin(half), 0, np.cos(half)])
    sim.rov.place(place, turn)
    sim.rov.place(2 * place - camera.world_from_camera[:3, 3], turn)
    return camera.capture(("sunlight", "attenuation")).rgb.astype(float)


@pytest.mark.parametrize("repeats", [-2, -1, 0, 1, 2])
@pytest.mark.parametrize("axis", [0, 1])
def test_nothing_jumps_where_the_frame_of_textures_repeats(plain: Simulator, repeats: int, axis: int) -> None:
    at = np.array([37.0, -21.0])
    at[axis] = REPEAT_M * repeats
    step = np.eye(2)[axis] * 1e-4
    before, after = picture(plain, *(at - step)), picture(plain, *(at + step))
    elsewhere = picture(plain, *(at + 1e4 * step))
    jump, usual = np.abs(after - before).mean(), np.abs(elsewhere - before).mean()
    assert usual > 3.0, "there is a pattern"
    assert jump < 0.05 * usual


def test_a_pattern_does_not_repeat_with_the_frame(plain: Simulator) -> None:
    one, other = picture(plain, 37.0, -21.0), picture(plain, 37.0 + REPEAT_M, -21.0)
    assert np.abs(one - other).mean() > 3.0
