"""Headless pictures in 3D of the true world and of voxel maps, cast with the rays that the sonar uses.

World ENU, metres. Pixel (0, 0) is the upper left one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from uwsim import _core
from uwsim.survey.true_surface import packed, voxel_keys

SUPERSAMPLE = 2
RAYS_AT_ONCE = 1 << 19
VIEW_DISTANCE = 2.0
MIN_ASPECT, MAX_ASPECT = 0.2, 2.0
MIN_BOX_M = 1.0e-3
FAR_M = 1.0e4
SHADOW_LIFT_M = 0.02
AMBIENT, SUN, SKY = 0.42, 0.50, 0.16
BACKGROUND_TOP, BACKGROUND_BOTTOM = np.array([0.93, 0.96, 0.98]), np.array([1.0, 1.0, 1.0])
CUT_EARTH = np.array([0.47, 0.44, 0.42])

HeightColours = Callable[[NDArray[np.float64]], NDArray[np.float64]]


@dataclass(frozen=True, eq=False)
class PinholeView:
    """A perspective camera that looks through a window in the plane one unit in front of it.

    world_from_view: (3, 3), columns right, up, backward. window: left, right, bottom, top in that plane.
    """

    eye_world_m: NDArray[np.float64]
    world_from_view: NDArray[np.float64]
    window: tuple[float, float, float, float]
    width: int
    height: int

    @property
    def pixel_rad(self) -> float:
        """The angle that a pixel covers, about."""
        return (self.window[1] - self.window[0]) / self.width

    def rays(self, rows: NDArray[np.int64], scale: int) -> NDArray[np.float64]:
        """Return unit directions (len(rows) * width * scale, 3) of whole rows of an image `scale` times as fine."""
        x0, x1, y0, y1 = self.window
        x = x0 + (x1 - x0) * (np.arange(self.width * scale) + 0.5) / (self.width * scale)
        y = y1 - (y1 - y0) * (rows + 0.5) / (self.height * scale)
        right, up, backward = self.world_from_view.T
        directions = x[:, None] * right + (y[:, None] * up - backward)[:, None, :]
        directions /= np.sqrt(1.0 + x * x + (y * y)[:, None])[..., None]
        return np.asarray(directions.reshape(-1, 3), np.float64)

    def project(self, points_world_m: NDArray[np.floating]) -> NDArray[np.float64]:
        """Return pixel coordinates (n, 2), column then row, of points (n, 3), nan if not in front of the camera."""
        x0, x1, y0, y1 = self.window
        view = (np.asarray(points_world_m, np.float64) - self.eye_world_m) @ self.world_from_view
        plane = view[:, :2] / np.where(view[:, 2:] < 0.0, -view[:, 2:], np.nan)
        columns = (plane[:, 0] - x0) / (x1 - x0) * self.width
        return np.stack([columns, (y1 - plane[:, 1]) / (y1 - y0) * self.height], axis=1)


def view_of_box(
    low_m: NDArray[np.float64], high_m: NDArray[np.float64], azimuth_rad: float, elevation_rad: float, width: int
) -> PinholeView:
    """Return the view of an axis-aligned box, `width` pixels wide and as high as it takes.

    The height is kept between MIN_ASPECT and MAX_ASPECT of the width: the view of a needle shows more than the needle.

    azimuth_rad: from the box's middle to the camera, counter-clockwise from east. elevation_rad: the camera's, above
    the horizon of the middle.
    """
    middle, half = (low_m + high_m) / 2.0, np.maximum((high_m - low_m) / 2.0, MIN_BOX_M / 2.0)
    low_m, high_m = middle - half, middle + half
    level = np.array([np.cos(azimuth_rad), np.sin(azimuth_rad), 0.0])
    backward = np.cos(elevation_rad) * level + np.array([0.0, 0.0, np.sin(elevation_rad)])
    right = np.array([-level[1], level[0], 0.0])
    axes = np.stack([right, np.cross(backward, right), backward], axis=1)
    distance_m = VIEW_DISTANCE * float(np.linalg.norm(high_m - low_m))
    corners = np.stack(np.meshgrid(*np.stack([low_m, high_m], axis=1), indexing="ij"), axis=-1).reshape(-1, 3) - middle
    view = corners @ axes
    plane = view[:, :2] / (distance_m - view[:, 2:])
    margin = 0.02 * np.ptp(plane[:, 0])
    (x0, y0), (x1, y1) = plane.min(axis=0) - margin, plane.max(axis=0) + margin
    wider = max((y1 - y0) / MAX_ASPECT - (x1 - x0), 0.0) / 2.0
    higher = max((x1 - x0) * MIN_ASPECT - (y1 - y0), 0.0) / 2.0
    x0, x1, y0, y1 = x0 - wider, x1 + wider, y0 - higher, y1 + higher
    height = max(round(width * (y1 - y0) / (x1 - x0)), 1)
    return PinholeView(middle + distance_m * backward, axes, (x0, x1, y0, y1), width, height)


@dataclass(frozen=True, eq=False)
class Prism:
    """An upright prism over the convex polygon, from floor_m upwards: what lies outside it is cut away."""

    corners_m: NDArray[np.float64]
    floor_m: float

    def span(
        self, origins_m: NDArray[np.float64], directions: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return where each ray enters and leaves, as ranges (n,); entry > exit for those that miss."""
        enter, leave = np.zeros(len(directions)), np.full(len(directions), np.inf)
        edges = np.roll(self.corners_m, -1, axis=0) - self.corners_m
        winding = np.sign(_cross2(self.corners_m, np.roll(self.corners_m, -1, axis=0)).sum())
        outward = winding * np.stack([edges[:, 1], -edges[:, 0], np.zeros(len(edges))], axis=1)
        planes = [(n, n[:2] @ corner) for n, corner in zip(outward, self.corners_m, strict=True)]
        planes.append((np.array([0.0, 0.0, -1.0]), -self.floor_m))
        for normal, offset in planes:
            inside = offset - origins_m @ normal
            towards = directions @ normal
            with np.errstate(divide="ignore", invalid="ignore"):
                crossing = inside / towards
            enter = np.where(towards < 0.0, np.maximum(enter, crossing), enter)
            leave = np.where(towards > 0.0, np.minimum(leave, crossing), leave)
            leave = np.where((towards == 0.0) & (inside < 0.0), -np.inf, leave)
        return enter, leave


def _cross2(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def voxel_world(occupied_centres_m: NDArray[np.floating], resolution_m: float) -> _core.World:
    """Build a world of cubes, one for each occupied voxel (n, 3); faces between two of them are left out."""
    keys = voxel_keys(occupied_centres_m, resolution_m)
    occupied = np.unique(packed(keys))
    vertices = []
    for axis in range(3):
        for side in (0, 1):
            step = np.zeros(3, np.int64)
            step[axis] = 2 * side - 1
            exposed = keys[~np.isin(packed(keys + step), occupied)]
            quad = np.zeros((4, 3), np.int64)
            quad[:, axis] = side
            first, second = (axis + 1) % 3, (axis + 2) % 3
            quad[:, first if side else second] = [0, 1, 1, 0]
            quad[:, second if side else first] = [0, 0, 1, 1]
            vertices.append((exposed[:, None, :] + quad) * resolution_m)
    corners = np.concatenate(vertices).reshape(-1, 3)
    base = np.arange(0, len(corners), 4)[:, None]
    triangles = np.concatenate([base + np.array([0, 1, 2]), base + np.array([0, 2, 3])]).astype(np.uint32)
    world = _core.World()
    world.add_solid("voxels", corners, triangles)
    return world


@dataclass(frozen=True, eq=False)
class Subject:
    """What a picture shows: rays into a world, and a colour (n, 3) in [0, 1] for heights (n,).

    Optional: a prism to cut it with, the ground's height_at for painting the cut, and the size of the voxels whose
    edges are drawn.
    """

    rays: _core.RayScene
    colours: HeightColours
    prism: Prism | None = None
    height_at: Callable[[NDArray[np.float64]], NDArray[np.float64]] | None = None
    voxel_m: float | None = None


def render(subject: Subject, view: PinholeView, sun_world: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Return the picture (height, width, 3). sun_world: unit vector (3,) towards the light."""
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
    """Return colours (n, 3) and ranges (n,), inf where nothing is hit."""
    eye = np.broadcast_to(view.eye_world_m, directions.shape)
    colour, depth = np.zeros(directions.shape), np.full(len(directions), np.inf)
    enter, leave = _span(subject.prism, eye, directions)
    alive = np.flatnonzero(enter < leave)
    origins = eye[alive] + directions[alive] * enter[alive, None]
    hits = subject.rays.cast(origins, directions[alive], FAR_M)
    reached = hits.ranges_m + enter[alive]
    inside = np.isfinite(reached) & (reached <= leave[alive])

    hit = alive[inside]
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
            cut = (enter[alive] > 0.0) & (origins[:, 2] < subject.height_at(origins[:, :2]))
        colour[alive[cut]] = CUT_EARTH
        depth[alive[cut]] = enter[alive[cut]]
    return colour, depth


def _span(
    prism: Prism | None, origins_m: NDArray[np.float64], directions: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    if prism is None:
        return np.zeros(len(directions)), np.full(len(directions), np.inf)
    return prism.span(origins_m, directions)


def _lit(subject: Subject, points_m: NDArray[np.float64], sun_world: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return whether the sun is seen from each point; what the prism cuts away throws no shadow."""
    directions = np.broadcast_to(sun_world, points_m.shape).copy()
    blocked_m = subject.rays.cast(points_m, directions, FAR_M).ranges_m
    _, leave = _span(subject.prism, points_m, directions)
    return np.asarray((blocked_m > leave) | np.isinf(blocked_m))


def _edge_shade(
    points_m: NDArray[np.float64], normals: NDArray[np.float64], voxel_m: float, pixel_m: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return a factor that draws thin lines where cubes meet, fading out where a cube is only a few pixels wide."""
    grid = points_m / voxel_m
    to_line = np.abs(grid - np.round(grid)) * voxel_m
    to_line[np.arange(len(normals)), np.abs(normals).argmax(axis=1)] = np.inf
    line = np.clip(1.2 - to_line.min(axis=1) / pixel_m, 0.0, 1.0)
    strength = np.clip((voxel_m / pixel_m - 3.0) / 6.0, 0.0, 1.0)
    return np.asarray(1.0 - 0.35 * line * strength)


def _depth_shade(depth: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a factor (rows, columns, 1) that darkens what lies behind its surroundings, so that shapes stand out.

    Unsharp masking of the depth buffer, Luft, Colditz and Deussen 2006, at two scales.
    """
    shade = np.ones((*depth.shape, 1))
    known = np.isfinite(depth)
    if not known.any():
        return shade
    near, far = depth[known].min(), depth[known].max()
    filled = np.where(known, depth, far)
    for share, strength in ((1 / 400, 0.25), (1 / 60, 0.25)):
        behind = filled - gaussian_filter(filled, depth.shape[1] * share)
        shade[..., 0] -= strength * np.clip(behind / (0.02 * (far - near) + 1e-9), 0.0, 1.0)
    return np.where(known[..., None], shade, 1.0)
