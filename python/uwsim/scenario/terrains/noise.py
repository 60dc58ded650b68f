"""The terrain `noise`: a lake bed generated from fractal simplex noise.

The noise has the same float32 results as the library FastNoiseLite, bit for bit. Perlin, "Noise hardware" (2001);
Gustavson, "Simplex noise demystified" (2005). Directions, hash and scale: OpenSimplex2 (public domain) in FastNoiseLite
1.1 by Jordan Peck and contributors (MIT licence).
"""

from __future__ import annotations

from typing import Annotated, Literal, cast

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from uwsim.scenario.build.terrain import FloatGrid, grid_axes, perlin_step
from uwsim.scenario.read.disk_cache import cached_arrays
from uwsim.scenario.spec.fields import InRange, Model, Point2, Size
from uwsim.scenario.spec.terrain import TerrainModel

Floats = NDArray[np.float32]
Ints = NDArray[np.int32]

PRIME_X, PRIME_Y = np.int32(501125321), np.int32(1136930381)
HASH_FACTOR = np.int32(0x27D4EB2D)
SKEW = np.float32(0.5) * (np.float32(np.sqrt(3)) - np.float32(1))
"""Turns equilateral triangles into halves of squares: x and y each gain (x + y) times this."""
UNSKEW = (np.float32(3) - np.float32(np.sqrt(3))) / np.float32(6)
SCALE = np.float32(99.83685446303647)
"""Makes the largest value of one octave 1."""
BLOCK = 1 << 15
"""Points computed at a time, so that intermediate arrays stay in the processor's cache."""


_ANGLES = np.radians([*np.tile(82.5 - 15.0 * np.arange(24), 5), *(67.5 - 45.0 * np.arange(8))])
GRADIENT_X, GRADIENT_Y = np.cos(_ANGLES).astype(np.float32), np.sin(_ANGLES).astype(np.float32)
"""The 128 gradients: 24 directions, 15 degrees apart, five times, and 8 directions, 45 degrees apart."""


def fractal_noise(x: Floats, y: Floats, *, seed: int, frequency: float, octaves: int, gain: float) -> Floats:
    """Return fractal noise in [-1, 1] at points, as a float32 array of their shape.

    x, y: float32 arrays of the same shape. frequency: frequency of the first octave, in cycles per unit of x; each
    further octave doubles it. gain: ratio of amplitudes between successive octaves. seed: in [0, 2^31).
    """
    values = np.empty(x.size, np.float32)
    flat_x, flat_y = x.ravel(), y.ravel()
    for start in range(0, x.size, BLOCK):
        part = slice(start, start + BLOCK)
        values[part] = _fractal(flat_x[part], flat_y[part], seed, np.float32(frequency), octaves, np.float32(gain))
    return values.reshape(x.shape)


def _fractal(x: Floats, y: Floats, seed: int, frequency: np.float32, octaves: int, gain: np.float32) -> Floats:
    x, y = x * frequency, y * frequency
    skew = (x + y) * SKEW
    x, y = x + skew, y + skew
    amplitudes = [np.float32(1)]
    for _ in range(octaves - 1):
        amplitudes.append(amplitudes[-1] * gain)
    amplitude = np.float32(1) / np.add.accumulate(np.array(amplitudes))[-1]
    total = np.zeros_like(x)
    for octave_seed in (seed + np.arange(octaves)).astype(np.int32):  # wraps, as in C
        total += _octave(x, y, octave_seed) * amplitude
        x, y = x * np.float32(2), y * np.float32(2)
        amplitude *= gain
    return total


def _octave(x: Floats, y: Floats, seed: np.int32) -> Floats:
    """Return the sum of three corners' gradients, each fading out at a distance of sqrt(0.5) from its corner."""
    column, row = _floor(x), _floor(y)
    x, y = x - column.astype(np.float32), y - row.astype(np.float32)
    unskew = (x + y) * UNSKEW
    x, y = x - unskew, y - unskew
    column *= PRIME_X
    row *= PRIME_Y
    half, one, two = np.float32(0.5), np.float32(1), np.float32(2)

    first = half - x * x - y * y
    slope = two * (one - two * UNSKEW) * (one / UNSKEW - two)
    offset = -two * (one - two * UNSKEW) * (one - two * UNSKEW)
    last = (slope * unskew + (offset + first)).astype(np.float32, copy=False)
    far = two * UNSKEW - one
    upper = y > x
    middle_x = x + np.where(upper, UNSKEW, UNSKEW - one)
    middle_y = y + np.where(upper, UNSKEW - one, UNSKEW)
    middle = half - middle_x * middle_x - middle_y * middle_y
    middle_column, middle_row = column + ~upper * PRIME_X, row + upper * PRIME_Y

    near = _corner(first, seed, column, row, x, y)
    between = _corner(middle, seed, middle_column, middle_row, middle_x, middle_y)
    opposite = _corner(last, seed, column + PRIME_X, row + PRIME_Y, x + far, y + far)
    return (near + between + opposite) * SCALE


def _floor(values: Floats) -> Ints:
    """Return the floor or, for negative whole numbers, one less, as FastNoiseLite does."""
    return values.astype(np.int32) - (values < 0)


def _corner(weight: Floats, seed: np.int32, column: Ints, row: Ints, x: Floats, y: Floats) -> Floats:
    weight = np.maximum(weight, 0)
    weight *= weight
    weight *= weight
    chosen = (seed ^ column ^ row) * HASH_FACTOR
    chosen ^= chosen >> np.int32(15)
    chosen >>= np.int32(1)
    chosen &= np.int32(127)
    return weight * (x * GRADIENT_X.take(chosen) + y * GRADIENT_Y.take(chosen))


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
