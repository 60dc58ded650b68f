"""Finds a pipe in a picture of the bed: a straight bar of the right width that differs from the bed on both sides.

The picture is projected onto the horizontal plane of the pipe's axis, so that lengths are in metres regardless of lens,
height and tilt. For each direction, values are averaged along all parallel lines (a Radon transform), and each bar as
wide as the pipe is compared with the strips on both sides. The bar that differs most is the pipe. The comparison uses
the logarithms of the three colours, whitened by their covariance in the picture (Mahalanobis distance): caustics,
shadows and lamps brighten and darken all colours together, so they count little compared with a difference of hue. The
method needs light, water that is clear down to the bed, and both sides of the pipe in the picture.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from uwsim.base import lens_model
from uwsim.base.arrays import Floats
from uwsim.missions.vehicle import LensLike, PictureLike

DIRECTIONS = 36
CELLS = 8  # across the pipe's width
# in cells: half the bar's width, and the gap to the strips of half its width on both sides
HALF, GAP = CELLS // 2, 1
FARTHEST = 1.2  # search radius around the camera, in multiples of its height above the pipe's axis
SHARPEST = 1.25  # minimum contrast of a pipe, in standard deviations
SHORTEST = 2.0  # minimum length of the bar in the picture, in pipe widths
LEAST_DEVIATION = 0.01  # a smaller standard deviation of a colour's logarithm is sensor noise
DARK = 2.0  # out of 255; a picture with a lower median is too dark


@dataclass(frozen=True, eq=False)
class SeenPipe:
    """A pipe in a picture. point_world_m: (2,), the point on the pipe's axis nearest to the point below the camera.

    direction (2,): unit vector along the pipe, of either sign. reach_m: the visible interval along it, relative to that
    point. contrast: in standard deviations.
    """

    point_world_m: Floats
    direction: Floats
    reach_m: tuple[float, float]
    contrast: float


def pipe_in_picture(frame: PictureLike, bed_z_m: float, diameter_m: float) -> SeenPipe | None:
    """Find a pipe in a frame with rgb, info and world_from_camera; return None if none is seen.

    bed_z_m: height (z) of the bed below the camera, on which the pipe lies.
    """
    camera_m = np.asarray(frame.world_from_camera, np.float64)[:3, 3]
    level_m = bed_z_m + 0.5 * diameter_m
    height_m = float(camera_m[2]) - level_m
    if not diameter_m < height_m < math.inf or float(np.median(frame.rgb)) < DARK:
        return None
    edge_m = diameter_m / CELLS
    count = math.ceil(FARTHEST * height_m / edge_m)
    steps = edge_m * np.arange(-count, count + 1)
    x, y = (grid.ravel() for grid in np.meshgrid(steps, steps))
    places = np.column_stack([x + camera_m[0], y + camera_m[1], np.full(len(x), level_m)])
    pixels, inside = pixels_of(places, frame.info, np.asarray(frame.world_from_camera, np.float64))
    if np.count_nonzero(inside) < (SHORTEST * CELLS) ** 2:
        return None
    values = _qualities(frame.rgb, pixels[inside])
    return _strongest_bar(x[inside], y[inside], values, edge_m, camera_m[:2])


def pixels_of(points_world_m: Floats, info: LensLike, world_from_camera: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Project points (n, 3) into a picture; return (column, row), (n, 2), and a mask (n,) of points inside it.

    world_from_camera: x ahead, y left, z up. Raises ValueError for an `info.d` of another lens model than ROS's.
    """
    seen = (points_world_m - world_from_camera[:3, 3]) @ world_from_camera[:3, :3]
    ahead = np.maximum(seen[:, 0], 1e-6)
    x, y = -seen[:, 1] / ahead, -seen[:, 2] / ahead
    k, d = np.asarray(info.k, np.float64).reshape(3, 3), np.asarray(info.d, np.float64)
    pixels = np.column_stack(lens_model.project(k, d, x, y))
    in_picture = (pixels >= 0.0).all(axis=1) & (pixels <= (info.width - 1, info.height - 1)).all(axis=1)
    return pixels, (seen[:, 0] > 0.0) & lens_model.shows(d, x, y) & in_picture


def _qualities(rgb: NDArray[np.uint8], pixels: Floats) -> Floats:
    """Return the logarithms of the colours (3, n) at pixels (n, 2), whitened (uncorrelated, with unit variance)."""
    at = pixels.T[::-1]
    logs = np.array([np.log1p(map_coordinates(rgb[:, :, k].astype(np.float32), at, order=1)) for k in range(3)])
    logs -= logs.mean(axis=1, keepdims=True)
    variances, axes = np.linalg.eigh(np.cov(logs))
    return np.asarray((axes.T @ logs) / np.sqrt(variances + LEAST_DEVIATION**2)[:, None])


def _strongest_bar(x: Floats, y: Floats, values: Floats, edge_m: float, below_m: Floats) -> SeenPipe | None:
    """Return the pipe, if any, found in the values (3, n) at x and y (n,), relative to the point below the camera."""
    best, contrast = (0, 0), 0.0
    for k in range(DIRECTIONS):
        line, first = _lines(x, y, k, edge_m)
        contrasts = _bars(line, values)
        if contrasts.max() > contrast:
            contrast, best = float(contrasts.max()), (k, int(contrasts.argmax()) + first)
    if contrast < SHARPEST:
        return None
    angle, across_m = math.pi * best[0] / DIRECTIONS, best[1] * edge_m
    direction = np.array([math.cos(angle), math.sin(angle)])
    aside = y * direction[0] - x * direction[1] - across_m
    reach_m = _reach(x * direction[0] + y * direction[1], np.abs(aside) / edge_m, values, edge_m)
    if reach_m[1] - reach_m[0] < SHORTEST * CELLS * edge_m:
        return None
    return SeenPipe(below_m + across_m * np.array([-direction[1], direction[0]]), direction, reach_m, contrast)


def _lines(x: Floats, y: Floats, k: int, edge_m: float) -> tuple[NDArray[np.int64], int]:
    """Return the indices (from 0) of the lines in direction k through points (n,), and line 0's offset in cells."""
    angle = math.pi * k / DIRECTIONS
    line = np.rint((y * math.cos(angle) - x * math.sin(angle)) / edge_m).astype(np.int64)
    first = int(line.min())
    return line - first, first


def _reach(along_m: Floats, aside: Floats, values: Floats, edge_m: float) -> tuple[float, float]:
    """Return the interval along a bar where the values are closer to the bar's mean than to that of its sides.

    aside: distance from the bar's centre line, in cells.
    """
    inner, outer = aside <= HALF, (aside > HALF + GAP) & (aside <= 2 * HALF + GAP)
    sides = values[:, outer].mean(axis=1)
    likeness = (values[:, inner].mean(axis=1) - sides) @ (values[:, inner] - sides[:, None])
    place = np.rint(along_m[inner] / (HALF * edge_m)).astype(np.int64)
    first = int(place.min())
    parts = np.bincount(place - first, likeness) / np.maximum(np.bincount(place - first), 1)
    is_pipe = np.concatenate([[False], parts > 0.5 * np.quantile(parts, 0.9), [False]])
    edges = np.flatnonzero(np.diff(is_pipe.astype(np.int8))).reshape(-1, 2)
    start, end = max(edges.tolist(), key=lambda run: run[1] - run[0])
    return (start + first - 0.5) * HALF * edge_m, (end + first - 0.5) * HALF * edge_m


def _bars(line: NDArray[np.int64], values: Floats) -> Floats:
    """Return the contrast of the bar on each line, given the line indices (n,) and values (3, n) of all points."""
    width = 2 * HALF + GAP  # to the far edge of a side
    count = np.pad(np.bincount(line).astype(np.float64), width)
    sums = np.array([np.pad(np.bincount(line, weights=row), width) for row in values])
    inside = _mean(sums, count, -HALF, HALF)
    port, starboard = _mean(sums, count, HALF + GAP + 1, width), _mean(sums, count, -width, -HALF - GAP - 1)
    over = np.stack([inside - port, inside - starboard])
    same_sign = over[0] * over[1] > 0.0
    differs = np.where(same_sign, np.abs(over).min(axis=0), 0.0)
    return np.asarray(np.nan_to_num(np.linalg.norm(differs, axis=0)))


def _mean(sums: Floats, count: Floats, first: int, last: int) -> Floats:
    """Return the mean over a band of lines about each line, (3, lines); NaN where too little is seen.

    first, last: the band, relative to the line. sums, count: padded with zeros by the width of a bar and one of its
    sides.
    """
    width = 2 * HALF + GAP
    lines = len(count) - 2 * width
    shifted = [slice(width + shift, width + shift + lines) for shift in range(first, last + 1)]
    total, seen = np.zeros((len(sums), lines)), np.zeros(lines)
    enough = np.ones(lines, bool)
    for part in shifted:
        enough &= count[part] >= SHORTEST * CELLS
        total += sums[:, part]
        seen += count[part]
    return np.where(enough, total / np.maximum(seen, 1.0), np.nan)
