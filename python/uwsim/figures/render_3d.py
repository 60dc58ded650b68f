"""Renders 3D pictures of the true world and of voxel maps without a display, with the rays that the sonar uses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from uwsim import _core
from uwsim.figures.clip_prism import ClipPrism
from uwsim.figures.pinhole_view import PinholeView

SUPERSAMPLE = 2
RAYS_AT_ONCE = 1 << 19
FAR_M = 1.0e4
SHADOW_LIFT_M = 0.02
AMBIENT, SUN, SKY = 0.42, 0.50, 0.16
BACKGROUND_TOP, BACKGROUND_BOTTOM = np.array([0.93, 0.96, 0.98]), np.array([1.0, 1.0, 1.0])
CUT_GROUND = np.array([0.47, 0.44, 0.42])

HeightColours = Callable[[NDArray[np.float64]], NDArray[np.float64]]


@dataclass(frozen=True, eq=False)
class Subject:
    """The content of a picture: a world to cast rays at, and colours (n, 3) in [0, 1] for heights (n,).

    prism: clips the world. height_at: height of the ground, to paint where the prism cuts it. voxel_m: size of the
    voxels whose edges are drawn.
    """

    rays: _core.RayScene
    colours: HeightColours
    prism: ClipPrism | None = None
    height_at: Callable[[NDArray[np.float64]], NDArray[np.float64]] | None = None
    voxel_m: float | None = None


def render(subject: Subject, view: PinholeView, sun_world: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Return the picture (height, width, 3) uint8. sun_world: unit vector (3,) towards the light."""
    fine = SUPERSAMPLE
    image, depth = np.empty((view.height, view.width, 3)), np.empty((view.height, view.width))
    step = max(RAYS_AT_ONCE // (view.width * fine * fine), 1)
    for start in range(0, view.height, step):
        stop = min(start + step, view.height)
        shaded, ranges_m = _shade(subject, view, view.rays(np.arange(start * fine, stop * fine), fine), sun_world)
        up = np.linspace(1.0 - start / view.height, 1.0 - stop / view.height, (stop - start) * fine)[:, None]
        sky = BACKGROUND_TOP * up[..., None] + BACKGROUND_BOTTOM * (1.0 - up[..., None])
        missed = np.isinf(ranges_m)
        shaded[missed] = np.broadcast_to(sky, (len(up), view.width * fine, 3)).reshape(-1, 3)[missed]
        blocks = (stop - start, fine, view.width, fine)
        image[start:stop] = shaded.reshape(*blocks, 3).mean(axis=(1, 3))
        depth[start:stop] = ranges_m.reshape(blocks).min(axis=(1, 3))
    image *= _depth_shade(depth)
    return np.asarray(np.clip(image, 0.0, 1.0) * 255.0 + 0.5, np.uint8)


def _shade(
    subject: Subject, view: PinholeView, directions: NDArray[np.float64], sun_world: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return colours (n, 3) and ranges (n,), inf for rays that hit nothing."""
    eye = np.broadcast_to(view.eye_world_m, directions.shape)
    colour, depth = np.zeros(directions.shape), np.full(len(directions), np.inf)
    enter, leave = _span(subject.prism, eye, directions)
    crossing = np.flatnonzero(enter < leave)
    origins = eye[crossing] + directions[crossing] * enter[crossing, None]
    hits = subject.rays.cast(origins, directions[crossing], FAR_M, exact=False)
    reached = hits.ranges_m + enter[crossing]
    inside = np.isfinite(reached) & (reached <= leave[crossing])

    hit = crossing[inside]
    depth[hit] = reached[inside]
    points = eye[hit] + directions[hit] * depth[hit, None]
    normals = np.asarray(hits.normals_world[inside], np.float64)
    normals *= -np.sign(np.einsum("ij,ij->i", normals, directions[hit]))[:, None]
    lit = _lit(subject, points + normals * SHADOW_LIFT_M, sun_world) * np.maximum(normals @ sun_world, 0.0)
    light = AMBIENT + SUN * lit + SKY * (0.5 + 0.5 * normals[:, 2])
    if subject.voxel_m is not None:
        light *= _edge_shade(points, normals, subject.voxel_m, depth[hit] * view.pixel_rad)
    colour[hit] = subject.colours(points[:, 2]) * light[:, None]

    if subject.height_at is not None:
        with np.errstate(invalid="ignore"):
            cut = (enter[crossing] > 0.0) & (origins[:, 2] < subject.height_at(origins[:, :2]))
        colour[crossing[cut]] = CUT_GROUND
        depth[crossing[cut]] = enter[crossing[cut]]
    return colour, depth


def _span(
    prism: ClipPrism | None, origins_m: NDArray[np.float64], directions: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    if prism is None:
        return np.zeros(len(directions)), np.full(len(directions), np.inf)
    return prism.span(origins_m, directions)


def _lit(subject: Subject, points_m: NDArray[np.float64], sun_world: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which points (n, 3) see the sun: (n,) bool. Parts outside the prism cast no shadow."""
    directions = np.broadcast_to(sun_world, points_m.shape).copy()
    blocked_m = subject.rays.cast(points_m, directions, FAR_M, exact=False).ranges_m
    _, leave = _span(subject.prism, points_m, directions)
    return np.asarray((blocked_m > leave) | np.isinf(blocked_m))


def _edge_shade(
    points_m: NDArray[np.float64], normals: NDArray[np.float64], voxel_m: float, pixel_m: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return factors (n,) that darken the edges of cubes; lines fade out where a cube is only a few pixels wide."""
    grid = points_m / voxel_m
    to_line = np.abs(grid - np.round(grid)) * voxel_m
    to_line[np.arange(len(normals)), np.abs(normals).argmax(axis=1)] = np.inf
    line = np.clip(1.2 - to_line.min(axis=1) / pixel_m, 0.0, 1.0)
    strength = np.clip((voxel_m / pixel_m - 3.0) / 6.0, 0.0, 1.0)
    return np.asarray(1.0 - 0.35 * line * strength)


def _depth_shade(depth: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return factors (rows, columns, 1) that darken pixels behind their surroundings, so that shapes stand out.

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
