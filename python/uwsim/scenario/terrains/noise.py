"""The terrain `noise`: a lake bed generated from fractal simplex noise."""

from __future__ import annotations

from typing import Annotated, Literal, cast

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from uwsim.scenario.build.simplex_noise import fractal_noise
from uwsim.scenario.build.terrain import FloatGrid, grid_axes, perlin_step
from uwsim.scenario.read.disk_cache import cached_arrays
from uwsim.scenario.spec.fields import InRange, Model, Point2, Size
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


class Scour(Model):
    """A hole that currents have dug round a structure: a flat floor and an even slope up to the bed around it.

    position_m: its middle. radius_m: radius of its floor. depth_m: of the floor below the bed without it.
    slope_deg: of its side; near the sand's angle of repose, some 30 deg (Sumer and Fredsoe 2002, The Mechanics of Scour
    in the Marine Environment, where a lone pile's equilibrium depth is 1.3 diameters in a current).
    """

    position_m: Point2
    radius_m: Size
    depth_m: Annotated[float, InRange(0.01, 100, "m")]
    slope_deg: Annotated[float, InRange(1, 80, "deg")] = 30.0


class NoiseTerrain(TerrainModel):
    """A bed of fractal OpenSimplex2 noise, ringed by hills.

    seed: seed of this noise; separate from the scenario's seed, so that the terrain is unchanged when the sensors'
    noise changes. bed_depth_m: mean depth of the bed. hill_height_m: largest deviation of the bed from it, up and down.
    hill_wavelength_m: wavelength of the broadest hills. octaves: number of octaves of noise; each additional one halves
    the wavelength. gain: ratio of heights between successive octaves. rim: hills around the lake, above the water; none
    by default. scour: holes round structures.
    """

    source: Literal["noise"]
    size_m: tuple[Size, Size] = Field(examples=[[100, 100]])
    seed: Annotated[int, InRange(0, 2**31 - 2)] = 0
    bed_depth_m: Annotated[float, InRange(0, 1000, "m", beyond="a deeper bed is a chart's: source: raster")] = Field(
        examples=[10]
    )
    hill_height_m: Annotated[float, InRange(0, 500, "m")] = Field(0.0, examples=[3])
    hill_wavelength_m: Size = 100.0
    octaves: Annotated[int, InRange(1, 8)] = 5
    gain: Annotated[float, InRange(0.01, 0.99)] = 0.4
    rim: Rim | None = None
    scour: Annotated[tuple[Scour, ...], Field(max_length=1000)] = ()

    def heights(self) -> NDArray[np.floating]:
        """See TerrainModel."""
        by = self.model_dump_json(exclude={"window_m", "strokes", *(() if self.scour else ("scour",))})
        (heights,) = cached_arrays(lambda: (_noise_heights(self).astype(np.float32),), "noise", by)
        return cast("NDArray[np.float32]", heights)


def _noise_heights(spec: NoiseTerrain) -> FloatGrid:
    """Return heights (ny, nx): a bed within hill_height_m of its mean depth, blended into the rim."""
    x, y = np.meshgrid(*grid_axes(spec.size_m, spec.spacing_m))
    bed = spec.hill_height_m * _noise(x, y, spec, spec.seed) - spec.bed_depth_m
    for hole in spec.scour:
        away_m = np.hypot(x - hole.position_m[0], y - hole.position_m[1]) - hole.radius_m
        bed = bed - np.maximum(hole.depth_m - np.tan(np.radians(hole.slope_deg)) * np.maximum(away_m, 0), 0)
    if spec.rim is None:
        return bed
    variation = 0.5 * _noise(x, y, spec, spec.seed + 1)
    share = _rim_share(x, y, spec.rim, variation)
    return (1 - share) * bed + share * spec.rim.height_m * (1 + variation)


def _rim_share(x: FloatGrid, y: FloatGrid, rim: Rim, variation: FloatGrid) -> FloatGrid:
    """Return the rim's weight: 1 outside the superellipse that touches the terrain edges, 0 from width_m inside it.

    The variation, in [-0.5, 0.5], creates bays and headlands.
    """
    half_x, half_y = x.max(), y.max()
    radius = (np.abs(x / half_x) ** SHORE_EXPONENT + np.abs(y / half_y) ** SHORE_EXPONENT) ** (1 / SHORE_EXPONENT)
    inset_m = (1 - radius) * min(half_x, half_y) * (1 + variation)
    return np.asarray(1 - perlin_step(inset_m / rim.width_m))


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
