import numpy as np
import pytest

from uwsim.scenario.terrains.noise import SKEW, fractal_noise


def test_the_noise_is_fast_noise_lites_to_the_bit() -> None:
    library = pytest.importorskip(
        "pyfastnoiselite.pyfastnoiselite", reason="pyfastnoiselite has no wheel for this Python"
    )
    draws = np.random.default_rng(1)
    for seed in (0, 52, int(draws.integers(2**31)), 2**31 - 2):
        extent_m, wavelength_m = 10 ** draws.uniform(1.0, 4.5), 10 ** draws.uniform(0.0, 3.5)
        octaves, gain = int(draws.integers(1, 9)), draws.uniform(0.01, 0.99)
        points = draws.uniform(-extent_m, extent_m, (2, 20_000)).astype(np.float32)
        points[:, :1000] = np.round(points[:, :1000])
        noise = library.FastNoiseLite(seed=seed)
        noise.noise_type = library.NoiseType.NoiseType_OpenSimplex2
        noise.fractal_type = library.FractalType.FractalType_FBm
        noise.frequency, noise.fractal_octaves, noise.fractal_gain = 1 / wavelength_m, octaves, gain
        ours = fractal_noise(*points, seed=seed, frequency=1 / wavelength_m, octaves=octaves, gain=gain)
        assert ours.dtype == np.float32
        np.testing.assert_array_equal(ours, noise.gen_from_coords(points))


def test_the_noise_is_zero_at_the_corners_of_its_triangles_and_at_most_one() -> None:
    column, row = (axis.ravel().astype(np.float32) for axis in np.meshgrid(np.arange(20), np.arange(20)))
    unskew = (column + row) * SKEW / (1 + 2 * SKEW)
    at_corners = fractal_noise(column - unskew, row - unskew, seed=3, frequency=1.0, octaves=1, gain=0.5)
    np.testing.assert_allclose(at_corners, 0, atol=2e-4)

    x, y = np.meshgrid(*(np.linspace(-20, 20, 500, dtype=np.float32),) * 2)
    values = fractal_noise(x, y, seed=3, frequency=1.0, octaves=1, gain=0.5)
    assert 0.9 < np.abs(values).max() <= 1
