"""Renders 3D pictures of the true world and of voxel maps by means of the sonar's ray casting; needs no display."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from uwsim import _core
from uwsim.figures.clip_prism import ClipPrism
from uwsim.figures.pinhole_view import PinholeView

SUPERSAMPLE = 2
SAME_COLOUR = 1.5 / 255.0
RAYS_AT_ONCE = 1 << 15  # a few megabytes of arrays per thread
FAR_M = 1.0e4
SHADOW_LIFT_M = 0.02
AMBIENT, SUN, SKY = 0.42, 0.50, 0.16
BACKGROUND_TOP, BACKGROUND_BOTTOM = np.array([0.93, 0.96, 0.98]), np.array([1.0, 1.0, 1.0])
CUT_GROUND = np.array([0.47, 0.44, 0.42])

HeightColours = Callable[[NDArray[np.float64]], NDArray[np.float64]]
Cast = Callable[[NDArray[np.float64], NDArray[np.float64]], _core.RayHits]
"""A function that casts rays from origins (n, 3) or (1, 3) along directions (n, 3)."""


def cast_at_world(rays: _core.RayScene) -> Cast:
    """Return a function that casts rays at a world, for use in pictures."""
    return partial(rays.cast, max_range_m=FAR_M, exact=False)


def cast_at_cubes(centres_world_m: NDArray[np.floating], edge_m: float) -> Cast:
    """Return a function that casts rays at cubes with centres (n, 3), aligned to multiples of their edge length."""
    return partial(_core.VoxelScene(centres_world_m, edge_m).cast, max_range_m=FAR_M)


@dataclass(frozen=True, eq=False)
class Subject:
    """The subject of a picture. cast: casts rays at it. colours: returns colours (n, 3) in [0, 1] for heights (n,).

    prism: clips the world. height_at: returns the ground height, so that the prism's cuts through the ground can be
    painted. voxel_m: size of the voxels, whose edges are drawn.
    """

    cast: Cast
    colours: HeightColours
    prism: ClipPrism | None = None
    height_at: Callable[[NDArray[np.float64]], NDArray[np.float64]] | None = None
    voxel_m: float | None = None


def render(subject: Subject, view: PinholeView, sun_world: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Return the picture (height, width, 3) uint8. sun_world: unit vector (3,) towards the light."""
    image, depth = np.empty((view.height, view.width, 3)), np.empty((view.height, view.width))
    step = max(RAYS_AT_ONCE // (view.width * SUPERSAMPLE**2), 1)

    def draw(start: int) -> None:
        rows = slice(start, min(start + step, view.height))
        image[rows], depth[rows] = _draw_rows(subject, view, rows, sun_world)

    with ThreadPoolExecutor(len(os.sched_getaffinity(0)), "render") as pool:
        list(pool.map(draw, range(0, view.height, step)))
    image *= _depth_shade(depth)
    return np.asarray(np.clip(image, 0.0, 1.0) * 255.0 + 0.5, np.uint8)


def _draw_rows(
    subject: Subject, view: PinholeView, rows: slice, sun_world: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the colours (rows, width, 3) and ranges (rows, width) of some rows; a pixel is the mean of its rays.

    A pixel is divided into SUPERSAMPLE x SUPERSAMPLE cells. The rays on its diagonal are cast first; if their colours
    agree, the other rays are assumed to agree as well.
    """
    fine = SUPERSAMPLE
    count = rows.stop - rows.start
    directions = view.rays(np.arange(rows.start * fine, rows.stop * fine), fine).reshape(
        count, fine, view.width, fine, 3
    )
    background = _background(view, rows)

    def draw(places: list[tuple[int, int]], at: NDArray[np.bool_]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        along = np.concatenate([directions[:, i, :, j][at] for i, j in places])
        shaded, ranges_m = _shade(subject, view, along, sun_world)
        missed = np.isinf(ranges_m)
        behind = np.concatenate([np.broadcast_to(background[:, None], (*at.shape, 3))[at]] * len(places))
        shaded[missed] = behind[missed]
        return shaded.reshape(len(places), -1, 3), ranges_m.reshape(len(places), -1)

    diagonal = [(i, i) for i in range(fine)]
    others = [(i, j) for i in range(fine) for j in range(fine) if i != j]
    colours, ranges_m = draw(diagonal, np.ones((count, view.width), bool))
    image = colours.mean(axis=0).reshape(count, view.width, 3)
    depth = ranges_m.min(axis=0).reshape(count, view.width)
    differ = (np.ptp(colours, axis=0).max(axis=1) > SAME_COLOUR).reshape(count, view.width)
    if differ.any():
        colours, ranges_m = draw(others, differ)
        image[differ] += (colours - image[differ]).sum(axis=0) / fine**2
        depth[differ] = np.minimum(depth[differ], ranges_m.min(axis=0))
    return image, depth


def _background(view: PinholeView, rows: slice) -> NDArray[np.float64]:
    """Return the background colour of each row, (rows, 3)."""
    up = 1.0 - (np.arange(rows.start, rows.stop)[:, None] + 0.5) / view.height
    return np.asarray(BACKGROUND_TOP * up + BACKGROUND_BOTTOM * (1.0 - up))


def _shade(
    subject: Subject, view: PinholeView, directions: NDArray[np.float64], sun_world: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the colours (n, 3) and ranges (n,) of rays; the range is inf if nothing is hit."""
    eye = view.eye_world_m
    colour, depth = np.zeros(directions.shape), np.full(len(directions), np.inf)
    enter, leave = _span(subject.prism, eye, directions)
    crossing = np.flatnonzero(enter < leave)
    along, enter, leave = directions[crossing], enter[crossing], leave[crossing]
    origins = eye + along * enter[:, None]
    hits = subject.cast(origins, along)
    reached = hits.ranges_m + enter
    inside = np.flatnonzero(reached <= np.minimum(leave, FAR_M))

    hit, along, depth_m = crossing[inside], along[inside], reached[inside]
    depth[hit] = depth_m
    points = eye + along * depth_m[:, None]
    normals = np.asarray(hits.normals_world[inside], np.float64)
    normals *= -np.sign(np.einsum("ij,ij->i", normals, along))[:, None]
    lit = np.maximum(normals @ sun_world, 0.0)
    facing = np.flatnonzero(lit)
    lit[facing] *= _lit(subject, points[facing] + normals[facing] * SHADOW_LIFT_M, sun_world)
    light = AMBIENT + SUN * lit + SKY * (0.5 + 0.5 * normals[:, 2])
    if subject.voxel_m is not None:
        light *= _edge_shade(points, normals, subject.voxel_m, depth_m * view.pixel_rad)
    colour[hit] = subject.colours(points[:, 2]) * light[:, None]

    if subject.height_at is not None:
        with np.errstate(invalid="ignore"):
            cut = (enter > 0.0) & (origins[:, 2] < subject.height_at(origins[:, :2]))
        colour[crossing[cut]] = CUT_GROUND
        depth[crossing[cut]] = enter[cut]
    return colour, depth


def _span(
    prism: ClipPrism | None, origins_m: NDArray[np.float64], directions: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    if prism is None:
        count = np.broadcast_shapes(origins_m.shape, directions.shape)[0]
        return np.zeros(count), np.full(count, np.inf)
    return prism.span(origins_m, directions)


def _lit(subject: Subject, points_m: NDArray[np.float64], sun_world: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return a mask (n,) of the points (n, 3) that are sunlit. Parts outside the prism cast no shadow."""
    directions = np.broadcast_to(sun_world, points_m.shape)
    blocked_m = subject.cast(points_m, directions).ranges_m
    _, leave = _span(subject.prism, points_m, sun_world)
    return np.asarray((blocked_m > leave) | np.isinf(blocked_m))


def _edge_shade(
    points_m: NDArray[np.float64], normals: NDArray[np.float64], voxel_m: float, pixel_m: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return factors (n,) that darken cube edges; the lines fade out where cubes are only a few pixels wide."""
    grid = points_m / voxel_m
    to_line = np.abs(grid - np.round(grid)) * voxel_m
    to_line[np.arange(len(normals)), np.abs(normals).argmax(axis=1)] = np.inf
    line = np.clip(1.2 - to_line.min(axis=1) / pixel_m, 0.0, 1.0)
    strength = np.clip((voxel_m / pixel_m - 3.0) / 6.0, 0.0, 1.0)
    return np.asarray(1.0 - 0.35 * line * strength)


def _depth_shade(depth: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return factors (rows, columns, 1) that darken pixels lying behind their surroundings, to make shapes stand out.

    Unsharp masking of the depth buffer (Luft, Colditz and Deussen 2006) at two scales.
    """
    shade = np.ones((*depth.shape, 1))
    known = np.isfinite(depth)
    if not known.any():
        return shade
    near, far = depth[known].min(), depth[known].max()
    filled = np.where(known, depth, far)
    for sigma_widths, strength in ((1 / 400, 0.25), (1 / 60, 0.25)):
        behind = filled - gaussian_filter(filled, depth.shape[1] * sigma_widths)
        shade[..., 0] -= strength * np.clip(behind / (0.02 * (far - near) + 1e-9), 0.0, 1.0)
    return np.where(known[..., None], shade, 1.0)
