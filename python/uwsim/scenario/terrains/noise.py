"""The terrain `noise`: a lake bed generated from fractal simplex noise."""

from __future__ import annotations

from typing import Annotated, Literal, cast

import numpy as np
from numpy.typing import NDArray

from uwsim.scenario.build.simplex_noise import fractal_noise
from uwsim.scenario.build.terrain_grid import FloatGrid, grid_axes
from uwsim.scenario.read.disk_cache import cached_arrays
from uwsim.scenario.spec.fields import InRange, Model, Size
from uwsim.scenario.spec.terrain import TerrainModel

SHORE_EXPONENT = 2.5
"""Exponent of the superellipse that forms the shore: 2 is an ellipse, infinity the terrain's rectangle."""


class Rim(Model):
    """Hills around the lake, above water everywhere along the terrain's edge.

    height_m: mean height of the crest, which varies by half of that. width_m: distance over which the bed rises to the
    crest.
    """

    height_m: Annotated[float, InRange(0.1, 1000, "m")]
    width_m: Size


class NoiseTerrain(TerrainModel):
    """A bed of fractal OpenSimplex2 noise, ringed by hills.

    seed: seed of this noise; separate from the scenario's seed, so that the terrain is unchanged when the sensors'
    noise changes. bed_depth_m: mean depth of the bed. hill_height_m: largest deviation of the bed from it, up and down.
    hill_wavelength_m: wavelength of the broadest hills. octaves: number of octaves of noise; each additional one halves
    the wavelength. gain: ratio of heights between successive octaves. rim: hills around the lake, above the water; none
    by default.
    """

    source: Literal["noise"]
    size_m: tuple[Size, Size]
    seed: Annotated[int, InRange(0, 2**31 - 2)] = 0
    bed_depth_m: Annotated[float, InRange(0, 1000, "m")]
    hill_height_m: Annotated[float, InRange(0, 500, "m")] = 0.0
    hill_wavelength_m: Size = 100.0
    octaves: Annotated[int, InRange(1, 8)] = 5
    gain: Annotated[float, InRange(0.01, 0.99)] = 0.4
    rim: Rim | None = None

    def heights(self) -> NDArray[np.floating]:
        """See TerrainModel."""
        by = self.model_dump_json(exclude={"window_m"})
        (heights,) = cached_arrays(lambda: (_noise_heights(self).astype(np.float32),), "noise", by)
        return cast("NDArray[np.float32]", heights)


def _noise_heights(spec: NoiseTerrain) -> FloatGrid:
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
