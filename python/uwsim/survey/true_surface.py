"""The true surface as the voxels that a perfect map would hold, with the sample points that stand for each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwsim import _core

TERRAIN_LABEL = 1
KEY_BITS = 21
KEY_OFFSET = 1 << (KEY_BITS - 1)


@dataclass(frozen=True, eq=False)
class SurfaceSamples:
    """Points on the true surface, sorted by voxel: samples of voxel i are [first_sample[i], first_sample[i + 1]).

    points_world_m: (n, 3). voxel_of_sample: (n,), index into voxel_keys. voxel_keys: (v, 3) int64, sorted and unique.
    """

    points_world_m: NDArray[np.float64]
    voxel_of_sample: NDArray[np.int64]
    voxel_keys: NDArray[np.int64]


def voxel_keys(points_world_m: NDArray[np.floating], resolution_m: float) -> NDArray[np.int64]:
    """Return the voxels that hold points (n, 3), on OctoMap's own grid: floor(x / resolution) on each axis."""
    return np.floor(np.asarray(points_world_m, np.float64) / resolution_m).astype(np.int64)


def voxel_centres_m(keys: NDArray[np.int64], resolution_m: float) -> NDArray[np.float64]:
    """Return the centres of voxels, (n, 3) keys to (n, 3)."""
    return np.asarray((keys + 0.5) * resolution_m, np.float64)


def packed(keys: NDArray[np.int64]) -> NDArray[np.int64]:
    """Pack keys within +-2^20 (OctoMap's are within 2^15) into one sortable integer each, x most significant."""
    shifted = keys + KEY_OFFSET
    return (shifted[:, 0] << (2 * KEY_BITS)) | (shifted[:, 1] << KEY_BITS) | shifted[:, 2]


def inside_polygon(xy_m: NDArray[np.floating], polygon_m: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Apply the even-odd rule to (n, 2) points in a simple polygon (k, 2), either winding."""
    x, y = xy_m[:, 0], xy_m[:, 1]
    inside = np.zeros(len(xy_m), bool)
    for (x0, y0), (x1, y1) in zip(polygon_m, np.roll(polygon_m, -1, axis=0), strict=True):
        if y0 != y1:
            straddles = (y0 > y) != (y1 > y)
            inside ^= straddles & (x < x0 + (y - y0) * ((x1 - x0) / (y1 - y0)))
    return inside


def sample_surface(world: _core.World, resolution_m: float, area_world_m: NDArray[np.float64]) -> SurfaceSamples:
    """Sample every triangle of terrain and solids at half a voxel or closer, where it lies inside the polygon.

    A voxel counts as surface when it holds a sample, so one that the surface merely nicks (by less than a third of its
    width or so) may not. At most one sample is kept for each eighth of a voxel: more would see nothing new. What lies
    under the terrain (a buried pipe's lower half) is no surface and left out.
    """
    spacing_m = resolution_m / 2.0
    vertices, triangles, labels = world.surface_mesh()
    corners = vertices[triangles]
    low, high = area_world_m.min(axis=0), area_world_m.max(axis=0)
    near = np.all((corners[:, :, :2].min(axis=1) <= high) & (corners[:, :, :2].max(axis=1) >= low), axis=1)

    points = []
    for is_terrain in (True, False):
        part = _sample_triangles(corners[near & ((labels == TERRAIN_LABEL) == is_terrain)], spacing_m)
        part = part[inside_polygon(part[:, :2], area_world_m)]
        if not is_terrain and len(part):
            with np.errstate(invalid="ignore"):
                part = part[~(world.height_at(part[:, :2]) > part[:, 2])]
        points.append(part)
    return _by_voxel(np.concatenate(points), resolution_m)


def _by_voxel(points_world_m: NDArray[np.float64], resolution_m: float) -> SurfaceSamples:
    eighths = voxel_keys(points_world_m, resolution_m / 2.0)
    _, first = np.unique(packed(eighths), return_index=True)
    points = points_world_m[first]
    keys = eighths[first] >> 1
    voxels, first_of_voxel, voxel_of_sample = np.unique(packed(keys), return_index=True, return_inverse=True)
    order = np.argsort(voxel_of_sample, kind="stable")
    return SurfaceSamples(points[order], voxel_of_sample[order], keys[first_of_voxel].reshape(len(voxels), 3))


def _sample_triangles(corners_m: NDArray[np.float64], spacing_m: float) -> NDArray[np.float64]:
    """Sample triangles (m, 3, 3) as points (n, 3), on rows parallel to the longest edge.

    Neither rows nor the points on them are further apart than spacing_m. Triangles with equal numbers of rows and
    columns share one template.
    """
    if not len(corners_m):
        return np.empty((0, 3))
    edges = np.roll(corners_m, -1, axis=1) - corners_m
    lengths = np.linalg.norm(edges, axis=2)
    longest = lengths.argmax(axis=1)
    turn = (longest[:, None] + np.arange(3)) % 3
    a, b, c = np.moveaxis(np.take_along_axis(corners_m, turn[:, :, None], axis=1), 1, 0)
    base_m = lengths.max(axis=1)
    area_m2 = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    columns = np.ceil(base_m / spacing_m).astype(np.int64)
    rows = np.ceil(2.0 * area_m2 / np.maximum(base_m, 1e-12) / spacing_m).astype(np.int64)

    points = []
    classes, class_of = np.unique(np.stack([columns, rows], axis=1), axis=0, return_inverse=True)
    for index, (column_count, row_count) in enumerate(classes):
        mine = np.flatnonzero(class_of == index)
        weights = _barycentric_grid(int(column_count), int(row_count))
        points.append(np.einsum("sk,kmd->msd", weights, np.stack([a[mine], b[mine], c[mine]])).reshape(-1, 3))
    return np.concatenate(points)


def _barycentric_grid(columns: int, rows: int) -> NDArray[np.float64]:
    """Return weights (samples, 3) of a base edge a-b in `columns` steps and rows that shrink towards the apex c."""
    weights = []
    for row in range(max(rows, 1) + 1):
        up = row / max(rows, 1)
        along = np.linspace(0.0, 1.0, max(int(np.ceil(columns * (1.0 - up))), 0) + 1)
        weights.append(np.stack([(1.0 - up) * (1.0 - along), (1.0 - up) * along, np.full_like(along, up)], axis=1))
    return np.concatenate(weights)
