"""Fractal simplex noise in two dimensions, with the same float32 results as the library FastNoiseLite, bit for bit.

Simplex noise: Perlin, "Noise hardware" (2001); Gustavson, "Simplex noise demystified" (2005). Directions, hash and
scale: OpenSimplex2 (public domain) in FastNoiseLite 1.1 by Jordan Peck and contributors (MIT licence).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

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
