"""The patterns of materials belong to the world: they do not change where the frame of textures repeats."""

import numpy as np
import pytest

from uwsim import Simulator

REPEAT_M = 256.0


def over_sand(bed_depth_m: float, detail: str | None) -> Simulator:
    terrain = {"source": "noise", "size_m": [1200, 1200], "spacing_m": 20, "hill_height_m": 0}
    rov = {"name": "rov", "model": "rov", "start": {"position_m": [30, 30, -4]}}
    world = {"name": "plain", "terrain": {**terrain, "bed_depth_m": bed_depth_m}, "vehicles": [rov]}
    return Simulator({**world, "detail": detail})


@pytest.fixture(scope="module", params=[None, "fine"])
def plain(request: pytest.FixtureRequest) -> Simulator:
    return over_sand(6, request.param)


def picture(sim: Simulator, x_m: float, y_m: float) -> np.ndarray:
    """Return a picture of the bed below a camera at (x, y), by daylight alone."""
    half, camera = np.pi / 4, sim.rov.cameras["front"].resized(96, 72)
    place, turn = np.array([x_m, y_m, -4.5]), np.array([0, np.sin(half), 0, np.cos(half)])
    sim.rov.place(place, turn)
    sim.rov.place(2 * place - camera.world_from_camera[:3, 3], turn)
    return camera.capture(("sunlight", "attenuation")).rgb.astype(float)


@pytest.mark.parametrize("axis", [0, 1])
def test_nothing_jumps_where_the_frame_of_textures_repeats(plain: Simulator, axis: int) -> None:
    step = np.eye(2)[axis] * 1e-4
    for repeats in (-2, -1, 0, 1):
        at = np.array([37.0, -21.0])
        at[axis] = REPEAT_M * repeats
        before, after, elsewhere = (picture(plain, *(at + k * step)) for k in (-1, 1, 1e4))
        jump, usual = np.abs(after - before).mean(), np.abs(elsewhere - before).mean()
        assert usual > 3.0, "there is a pattern"
        assert jump < 0.05 * usual, repeats


def test_a_pattern_does_not_repeat_with_the_frame(plain: Simulator) -> None:
    one, other = picture(plain, 37.0, -21.0), picture(plain, 37.0 + REPEAT_M, -21.0)
    assert np.abs(one - other).mean() > 3.0


def test_detail_fades_before_a_pixel_covers_it() -> None:
    near, far = ([over_sand(depth_m, detail) for detail in (None, "fine")] for depth_m in (5, 60))
    one, other = (picture(sim, 37.0, -21.0) for sim in near)
    assert np.abs(one - other).mean() > 1.0, "there is detail"
    one, other = (picture(sim, 37.0, -21.0) for sim in far)
    np.testing.assert_array_equal(one, other)


def test_cameras_alone_perceive_detail() -> None:
    found = []
    for sim in (over_sand(6, detail) for detail in (None, "fine")):
        sim.rov.release()
        frame, ping = sim.rov.cameras["front"].resized(96, 72).capture(), sim.rov.sonar.ping()
        found.append((frame.labels, frame.depth_m, ping.ranges_m, ping.intensity_db))
    for one, other in zip(*found, strict=True):
        np.testing.assert_array_equal(one, other)
