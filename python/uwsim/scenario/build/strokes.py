"""Strokes of a brush on a bed: hills, holes, ridges and trenches, and smoothed places."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from uwsim.scenario.build.terrain_grid import FloatGrid, perlin_step
from uwsim.scenario.spec.terrain import Stroke


def with_strokes(heights_m: NDArray[np.floating], strokes: Sequence[Stroke], spacing_m: float) -> NDArray[np.floating]:
    """Return heights (ny, nx) of a grid centred on the world's origin with strokes, one after another."""
    if not strokes:
        return heights_m
    drawn = heights_m.astype(np.float64)
    for stroke in strokes:
        _draw(drawn, stroke, spacing_m)
    return drawn


def _draw(heights: FloatGrid, stroke: Stroke, spacing_m: float) -> None:
    reach = stroke.width_m / 2 / spacing_m  # in cells, as all below
    line = np.asarray(stroke.line_m) / spacing_m + (np.array(heights.shape[::-1]) - 1) / 2
    rows, columns = _near(line, reach, heights.shape)
    drawn = heights[rows, columns]
    if drawn.size == 0:
        return
    line -= (columns.start, rows.start)
    away = np.full(drawn.shape, np.inf)
    for start, end in zip(line[[0, *range(len(line) - 1)]], line, strict=True):
        part = _near(np.stack([start, end]), reach, drawn.shape)
        y, x = np.ogrid[part]
        way = end - start
        share = np.clip(((x - start[0]) * way[0] + (y - start[1]) * way[1]) / max(way @ way, 1e-12), 0, 1)
        distance = np.hypot(x - start[0] - share * way[0], y - start[1] - share * way[1])
        away[part] = np.minimum(away[part], distance)
    weight = perlin_step(1 - away / reach)
    if stroke.smooth > 0:
        drawn += stroke.smooth * weight * (_mean(heights, rows, columns, reach) - drawn)
    drawn += stroke.height_m * weight


def _near(points: FloatGrid, reach: float, shape: tuple[int, ...]) -> tuple[slice, slice]:
    """Return the rows and the columns of a grid within reach of a box around points (n, 2); empty ones outside."""
    low = np.clip(np.floor(points.min(axis=0) - reach), 0, shape[::-1]).astype(int)
    high = np.clip(np.ceil(points.max(axis=0) + reach) + 1, 0, shape[::-1]).astype(int)
    return slice(low[1], high[1]), slice(low[0], high[0])


def _mean(heights: FloatGrid, rows: slice, columns: slice, reach: float) -> FloatGrid:
    """Return the mean of a part's neighbours within half the reach along each axis, the nearest repeated at edges."""
    from scipy.ndimage import uniform_filter  # here: slow to import

    half = max(round(reach / 2), 1)
    top, left = max(rows.start - half, 0), max(columns.start - half, 0)
    mean = uniform_filter(heights[top : rows.stop + half, left : columns.stop + half], 2 * half + 1, mode="nearest")
    return np.asarray(mean[rows.start - top : rows.stop - top, columns.start - left : columns.stop - left])
