"""The true surface as the voxels that a perfect map would hold, each with sample points on the surface."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.mapping.voxel_keys import pack_keys, unpack_keys, voxel_keys
from uwsim.scoring.polygon import inside_polygon
from uwsim.scoring.sampled_triangles import ROWS_AT_ONCE, Box, SampledTriangles, sample_points

TERRAIN_LABEL = 1
MAX_VOXELS = 50_000_000
TILE_VOXELS, TILE_BITS = 256, 9
PLACE_BITS = 63 - 3 * TILE_BITS - 3


class TooManyVoxelsError(ValueError):
    """A surface has more voxels than can be sampled."""


@dataclass(frozen=True, eq=False)
class SurfaceSamples:
    """Points on the true surface, sorted by voxel.

    points_world_m: (n, 3). voxel_of_sample: (n,), index into voxel_keys. voxel_keys: (v, 3) int64, sorted and unique.
    """

    points_world_m: NDArray[np.float64]
    voxel_of_sample: NDArray[np.int64]
    voxel_keys: NDArray[np.int64]


def sample_surface(world: _core.World, resolution_m: float, area_world_m: NDArray[np.float64]) -> SurfaceSamples:
    """Return the samples of all surface_tiles in one piece."""
    tiles = list(surface_tiles(world, resolution_m, area_world_m))
    points = np.concatenate([np.empty((0, 3)), *[tile.points_world_m for tile in tiles]])
    keys = np.concatenate(
        [np.empty(0, np.int64), *[pack_keys(tile.voxel_keys)[tile.voxel_of_sample] for tile in tiles]]
    )
    voxels, voxel_of_sample = np.unique(keys, return_inverse=True)
    order = np.argsort(voxel_of_sample, kind="stable")
    return SurfaceSamples(points[order], voxel_of_sample[order], unpack_keys(voxels))


def surface_tiles(
    world: _core.World, resolution_m: float, area_world_m: NDArray[np.float64], within_m: Box | None = None
) -> Iterator[SurfaceSamples]:
    """Return the samples of each of surface_tile_jobs that has any."""
    tiles = (job() for job in surface_tile_jobs(world, resolution_m, area_world_m, within_m))
    yield from (tile for tile in tiles if len(tile.points_world_m))


def surface_tile_jobs(
    world: _core.World,
    resolution_m: float,
    area_world_m: NDArray[np.float64],
    within_m: Box | None = None,
    max_voxels: int | None = None,
) -> Iterator[Callable[[], SurfaceSamples]]:
    """Sample every triangle of terrain and solids, where it lies inside the polygon, at half a voxel or closer.

    Yields functions that each sample a tile, on any thread.

    A voxel counts as surface when it holds a sample, so a voxel that the surface merely clips (by less than about a
    third of its width) may not count. At most one sample is kept for each octant of a voxel: more would see nothing
    new. Parts of solids under the terrain (the lower half of a buried pipe) are not surface and are discarded.

    The samples come in tiles of at most TILE_VOXELS on a side that share no voxel, so memory depends neither on the
    size of the area nor on the triangles outside it. within_m: a box, corners (3,), beyond which nothing is sampled.
    Raises TooManyVoxelsError, before the first tile, when the surface is estimated to have more than max_voxels
    (default: MAX_VOXELS).
    """
    vertices, triangles, labels = world.surface_mesh()
    low, high = np.append(area_world_m.min(axis=0), -np.inf), np.append(area_world_m.max(axis=0), np.inf)
    if within_m is not None:
        low, high = np.maximum(low, within_m[0]), np.minimum(high, within_m[1])
    is_terrain = labels == TERRAIN_LABEL
    sides = np.zeros(len(vertices), np.uint8)
    for side, outside in enumerate((*(vertices < low).T, *(vertices > high).T)):
        sides |= outside.astype(np.uint8) << side
    first, second, third = sides[triangles].T
    beyond = (first & second & third) != 0  # all corners lie beyond one side of the box
    parts = []
    for kind in (is_terrain, ~is_terrain):
        near = triangles[kind & ~beyond]
        parts.append(SampledTriangles.from_corners(vertices[near], resolution_m / 2.0))
    if not any(len(part.a) for part in parts):
        return
    low = np.maximum(low, np.min([part.low.min(axis=0, initial=np.inf) for part in parts], axis=0))
    high = np.minimum(high, np.max([part.high.max(axis=0, initial=-np.inf) for part in parts], axis=0))
    box_voxels = sum(_voxel_estimate(part, low, high, resolution_m) for part in parts)
    _require_scorable(box_voxels, low, high, area_world_m, MAX_VOXELS if max_voxels is None else max_voxels)
    lowest, highest = voxel_keys(np.stack([low, high]), resolution_m)
    for first, last, near_parts in _tiles(parts, lowest - 1, highest + 2, resolution_m):  # one voxel more, for rounding
        yield partial(_sample_tile, world, near_parts, first, last, resolution_m, area_world_m)


def _voxel_estimate(
    triangles: SampledTriangles, low_m: NDArray[np.float64], high_m: NDArray[np.float64], resolution_m: float
) -> float:
    """Return the approximate number of voxels that the triangles run through in the box, from their area in it.

    A plane of area A and unit normal n crosses A |n|_1 / resolution^2 voxels.
    """
    low_m, high_m = low_m - 0.01 * resolution_m, high_m + 0.01 * resolution_m  # for rounding
    crossed = np.abs(np.cross(triangles.b - triangles.a, triangles.c - triangles.a)).sum(axis=1)
    within = np.all((triangles.low >= low_m) & (triangles.high <= high_m), axis=1)
    total, strips = 0.5 * float(crossed[within].sum()), 16
    across = np.flatnonzero(~within)
    for start in range(0, len(across), ROWS_AT_ONCE // strips):
        batch = across[start : start + ROWS_AT_ONCE // strips]
        part = triangles.at(batch)
        lowest, highest = part.heights_within(low_m, high_m)
        at = np.repeat(np.arange(len(batch)), strips)
        up = (lowest[:, None] + (highest - lowest)[:, None] * (np.arange(strips) + 0.5) / strips).ravel()
        enter, leave = part.along_within(at, up, low_m, high_m)
        strip = (1.0 - up) * np.maximum(leave - enter, 0.0) * ((highest - lowest) / strips)[at]
        total += float((strip * crossed[batch][at]).sum())
    return total / resolution_m**2


def _require_scorable(
    box_voxels: float,
    low_m: NDArray[np.float64],
    high_m: NDArray[np.float64],
    area_world_m: NDArray[np.float64],
    max_voxels: int,
) -> None:
    x, y = (low + (high - low) * (np.arange(128) + 0.5) / 128 for low, high in zip(low_m[:2], high_m[:2], strict=True))
    grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    voxels = box_voxels * float(inside_polygon(grid, area_world_m).mean())
    if voxels > max_voxels:
        rule = f"must be at most {max_voxels / 1e6:g} million to be scored: choose larger voxels or a smaller area"
        raise TooManyVoxelsError(f"voxels of the true surface = about {voxels / 1e6:.0f} million: {rule}")


def _tiles(
    parts: list[SampledTriangles], first: NDArray[np.int64], last: NDArray[np.int64], resolution_m: float
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64], list[SampledTriangles]]]:
    """Bisect the box of voxels [first, last) down to TILE_VOXELS; return the boxes that meet triangles, with these."""
    near = [part.touching(*_box_m(first, last, resolution_m)) for part in parts]
    if not any(len(part.a) for part in near):
        return
    sides = last - first
    if sides.max() <= TILE_VOXELS:
        yield first, last, near
        return
    cut = np.eye(3, dtype=bool)[sides.argmax()]
    middle = (first + last) // 2
    yield from _tiles(near, first, np.where(cut, middle, last), resolution_m)
    yield from _tiles(near, np.where(cut, middle, first), last, resolution_m)


def _sample_tile(
    world: _core.World,
    parts: list[SampledTriangles],
    first: NDArray[np.int64],
    last: NDArray[np.int64],
    resolution_m: float,
    area_world_m: NDArray[np.float64],
) -> SurfaceSamples:
    """Sample [terrain, solids] in the box of voxels [first, last); at most one point per octant of a voxel."""
    kept, kept_points = np.empty(0, np.int64), np.empty((0, 3))
    for is_solid, part in enumerate(parts):
        for points in sample_points(part, *_box_m(first, last, resolution_m)):
            octants = voxel_keys(points, resolution_m / 2.0) - 2 * first
            within = np.ones(len(points), bool)
            for axis in range(3):
                within &= (octants[:, axis] >= 0) & (octants[:, axis] < 2 * (last - first)[axis])
            mine = np.flatnonzero(within)
            mine = mine[inside_polygon(points[mine, :2], area_world_m)]
            if is_solid and len(mine):
                with np.errstate(invalid="ignore"):
                    mine = mine[~(world.height_at(points[mine, :2]) > points[mine, 2])]
            # Points kept so far come first and stay.
            keys = np.concatenate([kept, _octant_keys(octants[mine])])
            index = _first_of_each(keys)
            kept, kept_points = keys[index], np.concatenate([kept_points, points[mine]])[index]
    voxels = kept >> 3
    is_first = np.concatenate([[True], voxels[1:] != voxels[:-1]]) if len(voxels) else np.empty(0, bool)
    packed = voxels[is_first]
    shifts = np.array([2 * TILE_BITS, TILE_BITS, 0])
    found = ((packed[:, None] >> shifts) & ((1 << TILE_BITS) - 1)) + first
    return SurfaceSamples(kept_points, np.cumsum(is_first) - 1, found)


def _octant_keys(octants: NDArray[np.int64]) -> NDArray[np.int64]:
    """Pack the octants (n, 3) of a tile's voxels into integers (n,) that sort by voxel, then by octant."""
    x, y, z = octants.T
    voxels = ((x >> 1) << (2 * TILE_BITS)) | ((y >> 1) << TILE_BITS) | (z >> 1)
    return np.asarray((voxels << 3) | ((x & 1) << 2) | ((y & 1) << 1) | (z & 1))


def _first_of_each(keys: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the index of the first of each of the keys (n,), in the order of the keys.

    Sorting integers that hold key and index is ten times as fast as np.unique.
    """
    places = np.sort((keys << PLACE_BITS) | np.arange(len(keys)))
    sorted_keys = places >> PLACE_BITS
    is_first = np.concatenate([[True], sorted_keys[1:] != sorted_keys[:-1]]) if len(keys) else np.empty(0, bool)
    return np.asarray(places[is_first] & ((1 << PLACE_BITS) - 1))


def _box_m(first: NDArray[np.int64], last: NDArray[np.int64], resolution_m: float) -> Box:
    """Return the corners (3,) of the box of voxels [first, last), slightly enlarged for rounding."""
    return np.asarray((first - 0.01) * resolution_m, np.float64), np.asarray((last + 0.01) * resolution_m, np.float64)
