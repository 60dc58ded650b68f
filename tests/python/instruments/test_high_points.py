"""A ping's highest points ahead, and its points above a height: computed in one pass, equal to NumPy's."""

import numpy as np
import pytest
from numpy.typing import NDArray

from uwsim import _core

POSITION, HEADING_RAD, HALF_WIDTH_M, AHEAD_M = np.array([3.0, -2.0, -5.0]), 0.7, 3.0, 20.0


def _scene(seed: int, dtype: type) -> tuple[NDArray[np.floating], NDArray[np.float64], NDArray[np.float64]]:
    """Return points, some of them NaN, in a rotated and translated frame, and the same points in the world."""
    random = np.random.default_rng(seed)
    points = random.uniform(-30, 30, (500, 3)).astype(dtype)
    points[random.random(500) < 0.1] = np.nan
    transform = np.eye(4)
    transform[:3, :3] = np.linalg.qr(random.normal(size=(3, 3)))[0]
    transform[:3, 3] = random.uniform(-5, 5, 3)
    return points, transform, points @ transform[:3, :3].T + transform[:3, 3]


def _in_corridor(points_world_m: NDArray[np.float64]) -> NDArray[np.bool_]:
    dx, dy = (points_world_m[:, :2] - POSITION[:2]).T
    along = np.cos(HEADING_RAD) * dx + np.sin(HEADING_RAD) * dy
    across = np.cos(HEADING_RAD) * dy - np.sin(HEADING_RAD) * dx
    return (along > -HALF_WIDTH_M) & (along < AHEAD_M) & (np.abs(across) < HALF_WIDTH_M)


def _highest(points_m: object, transform: object) -> tuple[float, float, float] | None:
    return _core.highest_in_corridor(points_m, transform, POSITION, HEADING_RAD, HALF_WIDTH_M, AHEAD_M)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("seed", range(5))
def test_both_equal_numpy(seed: int, dtype: type) -> None:
    points, transform, world = _scene(seed, dtype)
    ahead = world[_in_corridor(world)]
    assert 5 < len(ahead) < 400
    np.testing.assert_allclose(_highest(points, transform), ahead[ahead[:, 2].argmax()], rtol=0, atol=1e-12)
    np.testing.assert_allclose(_core.points_above(points, transform, 4.0), world[world[:, 2] > 4.0], rtol=0, atol=1e-12)


def test_of_equally_high_points_the_first_is_taken_and_without_points_there_is_none() -> None:
    points = np.array([[4.1, -1.3, -2.7], [5.2, -0.4, -2.7]])
    assert _highest(points, np.eye(4)) == (4.1, -1.3, -2.7)
    assert np.array_equal(_core.points_above(points, np.eye(4), -3.0), points)
    for nothing in (np.empty((0, 3)), np.full((4, 3), np.nan), [[-100.0, 0, 0]]):
        assert _highest(nothing, np.eye(4)) is None
        assert _core.points_above(nothing, np.eye(4), 4.0).shape == (0, 3)


@pytest.mark.parametrize(
    ("points", "transform", "message"),
    [
        (np.zeros((4, 2)), np.eye(4), "points_m.shape"),
        (np.zeros((4, 3)), np.eye(3), "world_from_points.shape"),
        (["a"], np.eye(4), "points_m"),
    ],
)
def test_wrong_shapes_are_refused(points: object, transform: object, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        _highest(points, transform)
    with pytest.raises(ValueError, match=message):
        _core.points_above(points, transform, 0.0)
