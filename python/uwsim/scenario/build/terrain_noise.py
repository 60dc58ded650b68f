"""A lake bed generated from fractal simplex noise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uwsim.scenario.build.simplex_noise import fractal_noise
from uwsim.scenario.build.terrain_grid import grid_axes
from uwsim.scenario.spec.terrain import NoiseTerrain, Rim

FloatGrid = NDArray[np.float64]
SHORE_EXPONENT = 2.5
"""Exponent of the superellipse that forms the shore: 2 is an ellipse, infinity the terrain's rectangle."""


def noise_heights(spec: NoiseTerrain) -> FloatGrid:
    """Return heights (ny, nx): a bed within hill_height_m of its mean depth, blended into the rim."""
    x, y = np.meshgrid(*grid_axes(spec.size_m, spec.spacing_m))
    bed = spec.hill_height_m * _noise(x, y, spec, spec.seed) - spec.bed_depth_m
    if spec.rim is None:
        return bed
    variation = 0.5 * _noise(x, y, spec, spec.seed + 1)
    share = _rim_share(x, y, spec.rim, variation)
    return (1 - share) * bed + share * spec.rim.height_m * (1 + variation)


def _rim_share(x: FloatGrid, y: FloatGrid, rim: Rim, variation: FloatGrid) -> FloatGrid:
    """Return the rim's weight: 1 outside the superellipse that touches the terrain edges, 0 from width_m inside it.

    The variation, in [-0.5, 0.5], creates bays and headlands. In between, the weight follows Perlin's step (2002),
    whose continuous second derivative avoids a crease that would produce echoes.
    """
    half_x, half_y = x.max(), y.max()
    radius = (np.abs(x / half_x) ** SHORE_EXPONENT + np.abs(y / half_y) ** SHORE_EXPONENT) ** (1 / SHORE_EXPONENT)
    inset_m = (1 - radius) * min(half_x, half_y) * (1 + variation)
    t = np.clip(inset_m / rim.width_m, 0, 1)
    return np.asarray(1 - t**3 * (t * (6 * t - 15) + 10))


def _noise(x: FloatGrid, y: FloatGrid, spec: NoiseTerrain, seed: int) -> FloatGrid:
    """Return fractal OpenSimplex2 noise in [-1, 1]. Its float32 coordinates have an error of 1 mm at 10 km."""
    values = fractal_noise(
        x.astype(np.float32),
        y.astype(np.float32),
        seed=seed,
        frequency=1 / spec.hill_wavelength_m,
        octaves=spec.octaves,
        gain=spec.gain,
    )
    return np.clip(values, -1, 1).astype(np.float64)
