"""The true surface as the voxels that a perfect map would hold, with the sample points that stand for each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from uwsim import _core

TERRAIN_LABEL = 1
KEY_BITS = 21
KEY_OFFSET = 1 << (KEY_BITS - 1)
MAX_VOXELS = 50_000_000
TILE_VOXELS = 256
ROWS_AT_ONCE, POINTS_AT_ONCE = 1 << 18, 1 << 20

Box = tuple[NDArray[np.float64], NDArray[np.float64]]


@dataclass(frozen=True, eq=False)
class SurfaceSamples:
    """Points on the true surface, sorted by voxel.

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


def unpacked(packed_keys: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the keys (n, 3) of what packed() made of them, (n,)."""
    shifts = np.array([2 * KEY_BITS, KEY_BITS, 0])
    return np.asarray(((packed_keys[:, None] >> shifts) & ((1 << KEY_BITS) - 1)) - KEY_OFFSET, np.int64)


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
    """Return the samples of surface_tiles in one piece."""
    tiles = list(surface_tiles(world, resolution_m, area_world_m))
    points = np.concatenate([np.empty((0, 3)), *[tile.points_world_m for tile in tiles]])
    keys = np.concatenate([np.empty(0, np.int64), *[packed(tile.voxel_keys)[tile.voxel_of_sample] for tile in tiles]])
    voxels, voxel_of_sample = np.unique(keys, return_inverse=True)
    order = np.argsort(voxel_of_sample, kind="stable")
    return SurfaceSamples(points[order], voxel_of_sample[order], unpacked(voxels))


def surface_tiles(
    world: _core.World, resolution_m: float, area_world_m: NDArray[np.float64], within_m: Box | None = None
) -> Iterator[SurfaceSamples]:
    """Sample every triangle of terrain and solids at half a voxel or closer, where it lies inside the polygon.

    A voxel counts as surface when it holds a sample, so one that the surface merely nicks (by less than a third of its
    width or so) may not. At most one sample is kept for each eighth of a voxel: more would see nothing new. What lies
    under the terrain (a buried pipe's lower half) is no surface and left out.

    The samples come in tiles of at most TILE_VOXELS on a side that share no voxel: memory depends neither on the size
    of the area nor on what the triangles do outside it. within_m: a box, corners (3,), beyond which nothing matters.
    Raises ValueError, before the first tile, when the surface has more than MAX_VOXELS voxels by estimate.
    """
    vertices, triangles, labels = world.surface_mesh()
    low, high = np.append(area_world_m.min(axis=0), -np.inf), np.append(area_world_m.max(axis=0), np.inf)
    if within_m is not None:
        low, high = np.maximum(low, within_m[0]), np.minimum(high, within_m[1])
    is_terrain = labels == TERRAIN_LABEL
    parts = []
    for mine in (is_terrain, ~is_terrain):
        far = np.zeros(int(mine.sum()), bool)
        for outside in (*(vertices < low).T, *(vertices > high).T):
            far |= outside[triangles[mine]].all(axis=1)
        parts.append(_Triangles.of(vertices[triangles[mine][~far]], resolution_m / 2.0))
    if not any(len(part.a) for part in parts):
        return
    low = np.maximum(low, np.min([part.low.min(axis=0, initial=np.inf) for part in parts], axis=0))
    high = np.minimum(high, np.max([part.high.max(axis=0, initial=-np.inf) for part in parts], axis=0))
    _require_few(sum(_voxel_estimate(part, low, high, resolution_m) for part in parts), low, high, area_world_m)
    lowest, highest = voxel_keys(np.stack([low, high]), resolution_m)
    for first, last, near_parts in _tiles(parts, lowest - 1, highest + 2, resolution_m):  # one more for rounding
        tile = _sample_tile(world, near_parts, first, last, resolution_m, area_world_m)
        if len(tile.points_world_m):
            yield tile


@dataclass(frozen=True, eq=False)
class _Triangles:
    """Triangles as grids of samples: rows parallel to the longest edge a-b, in shrinking steps up to the corner c.

    a, b, c, low, high: (m, 3). columns: steps along a-b, rows: steps from it to c, (m,), so many that neither the
    rows nor the points on them are further apart than the spacing. Sorted by both.
    """

    a: NDArray[np.float64]
    b: NDArray[np.float64]
    c: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    columns: NDArray[np.int64]
    rows: NDArray[np.int64]

    @classmethod
    def of(cls, corners_m: NDArray[np.float64], spacing_m: float) -> Self:
        lengths = np.linalg.norm(np.roll(corners_m, -1, axis=1) - corners_m, axis=2)
        turn = (lengths.argmax(axis=1)[:, None] + np.arange(3)) % 3
        a, b, c = np.moveaxis(np.take_along_axis(corners_m, turn[:, :, None], axis=1), 1, 0)
        base_m = lengths.max(axis=1, initial=0.0)
        area_m2 = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
        columns = np.ceil(base_m / spacing_m).astype(np.int64)
        rows = np.ceil(2.0 * area_m2 / np.maximum(base_m, 1e-12) / spacing_m).astype(np.int64)
        every = cls(a, b, c, corners_m.min(axis=1), corners_m.max(axis=1), columns, np.maximum(rows, 1))
        return every.at(np.lexsort((rows, columns)))

    def at(self, index: NDArray[np.int64]) -> Self:
        """Return some of them."""
        corners = self.a[index], self.b[index], self.c[index]
        return type(self)(*corners, self.low[index], self.high[index], self.columns[index], self.rows[index])

    def touching(self, low_m: NDArray[np.float64], high_m: NDArray[np.float64]) -> Self:
        """Return those whose bounding boxes meet the box."""
        return self.at(np.flatnonzero(np.all((self.low <= high_m) & (self.high >= low_m), axis=1)))

    def heights_within(
        self, low_m: NDArray[np.float64], high_m: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return (m,) bounds of what the planes' parts in the box reach of the way from a-b, 0, to c, 1."""
        along = (self.b - self.a) / np.maximum(np.linalg.norm(self.b - self.a, axis=1), 1e-12)[:, None]
        upright = self.c - self.a - np.einsum("ij,ij->i", self.c - self.a, along)[:, None] * along
        slope = upright / np.maximum(np.einsum("ij,ij->i", upright, upright), 1e-24)[:, None]
        middle = np.einsum("ij,ij->i", (low_m + high_m) / 2.0 - self.a, slope)
        reach = np.abs(slope) @ ((high_m - low_m) / 2.0)
        flat = self.rows < 4  # so flat that rounding may have its way with the slope
        lowest, highest = np.clip(middle - reach, 0.0, 1.0), np.clip(middle + reach, 0.0, 1.0)
        return np.where(flat, 0.0, lowest), np.where(flat, 1.0, highest)

    def along_within(
        self, at: NDArray[np.int64], up: NDArray[np.float64], low_m: NDArray[np.float64], high_m: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return where rows (r,) of triangles `at` enter and leave the box, of their length; entry > exit for none."""
        enter, leave = np.zeros(len(at)), np.ones(len(at))
        for axis in range(3):
            a, b, c = self.a[at, axis], self.b[at, axis], self.c[at, axis]
            start, way = (1.0 - up) * a + up * c, (1.0 - up) * (b - a)
            with np.errstate(divide="ignore", invalid="ignore"):
                one, other = (low_m[axis] - start) / way, (high_m[axis] - start) / way
            parallel = way == 0.0
            beside = parallel & ((start < low_m[axis]) | (start > high_m[axis]))
            enter = np.where(parallel, enter, np.maximum(enter, np.minimum(one, other)))
            leave = np.where(parallel, leave, np.minimum(leave, np.maximum(one, other)))
            leave[beside] = -1.0
        return np.minimum(enter, 2.0), np.maximum(leave, -1.0)


def _voxel_estimate(
    triangles: _Triangles, low_m: NDArray[np.float64], high_m: NDArray[np.float64], resolution_m: float
) -> float:
    """Return about how many voxels the triangles run through inside the box, from their area in it.

    A plane of area A and unit normal n crosses A |n|_1 / resolution^2 voxels.
    """
    low_m, high_m = low_m - 0.01 * resolution_m, high_m + 0.01 * resolution_m  # for rounding
    crossed = np.abs(np.cross(triangles.b - triangles.a, triangles.c - triangles.a)).sum(axis=1)
    within = np.all((triangles.low >= low_m) & (triangles.high <= high_m), axis=1)
    total, strips = 0.5 * float(crossed[within].sum()), 16
    across = np.flatnonzero(~within)
    for start in range(0, len(across), ROWS_AT_ONCE // strips):
        some = across[start : start + ROWS_AT_ONCE // strips]
        part = triangles.at(some)
        lowest, highest = part.heights_within(low_m, high_m)
        at = np.repeat(np.arange(len(some)), strips)
        up = (lowest[:, None] + (highest - lowest)[:, None] * (np.arange(strips) + 0.5) / strips).ravel()
        enter, leave = part.along_within(at, up, low_m, high_m)
        strip = (1.0 - up) * np.maximum(leave - enter, 0.0) * ((highest - lowest) / strips)[at]
        total += float((strip * crossed[some][at]).sum())
    return total / resolution_m**2


def _require_few(
    box_voxels: float, low_m: NDArray[np.float64], high_m: NDArray[np.float64], area_world_m: NDArray[np.float64]
) -> None:
    x, y = (low + (high - low) * (np.arange(128) + 0.5) / 128 for low, high in zip(low_m[:2], high_m[:2], strict=True))
    grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    voxels = box_voxels * float(inside_polygon(grid, area_world_m).mean())
    if voxels > MAX_VOXELS:
        rule = f"must be at most {MAX_VOXELS / 1e6:g} million to be scored: take larger voxels or a smaller area"
        raise ValueError(f"voxels of the true surface = about {voxels / 1e6:.0f} million: {rule}")


def _tiles(
    parts: list[_Triangles], first: NDArray[np.int64], last: NDArray[np.int64], resolution_m: float
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64], list[_Triangles]]]:
    """Halve the box of voxels [first, last) down to TILE_VOXELS; return what boxes meet triangles, and which."""
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
    parts: list[_Triangles],
    first: NDArray[np.int64],
    last: NDArray[np.int64],
    resolution_m: float,
    area_world_m: NDArray[np.float64],
) -> SurfaceSamples:
    """Sample [terrain, solids] in the box of voxels [first, last), the points sorted by eighths of voxels."""
    kept, kept_points = np.empty(0, np.int64), np.empty((0, 3))
    for is_solid, part in enumerate(parts):
        for points in _grid_points(part, *_box_m(first, last, resolution_m)):
            eighths = voxel_keys(points, resolution_m / 2.0)
            mine = np.all((eighths >> 1 >= first) & (eighths >> 1 < last), axis=1)
            mine[mine] = inside_polygon(points[mine, :2], area_world_m)
            if is_solid and mine.any():
                with np.errstate(invalid="ignore"):
                    mine[mine] = ~(world.height_at(points[mine, :2]) > points[mine, 2])
            # What was kept comes first, so that it stays.
            keys = np.concatenate([kept, packed(eighths[mine] - 2 * first)])
            kept, index = np.unique(keys, return_index=True)
            kept_points = np.concatenate([kept_points, points[mine]])[index]
    voxels = packed((unpacked(kept) >> 1) + first)
    keys, voxel_of_sample = np.unique(voxels, return_inverse=True)
    order = np.argsort(voxel_of_sample, kind="stable")
    return SurfaceSamples(kept_points[order], voxel_of_sample[order], unpacked(keys))


def _box_m(first: NDArray[np.int64], last: NDArray[np.int64], resolution_m: float) -> Box:
    """Return the corners of voxels [first, last), a little apart for rounding."""
    return np.asarray((first - 0.01) * resolution_m, np.float64), np.asarray((last + 0.01) * resolution_m, np.float64)


def _grid_points(
    triangles: _Triangles, low_m: NDArray[np.float64], high_m: NDArray[np.float64]
) -> Iterator[NDArray[np.float64]]:
    """Return the triangles' samples (n, 3) that lie in the box, and few that do not, POINTS_AT_ONCE or so at a time."""
    lowest, highest = triangles.heights_within(low_m, high_m)
    first_row = np.maximum(np.floor(lowest * triangles.rows).astype(np.int64) - 1, 0)
    last_row = np.minimum(np.ceil(highest * triangles.rows).astype(np.int64) + 1, triangles.rows)
    for some in _batches(last_row - first_row + 1, ROWS_AT_ONCE):
        at, row = _ranges(first_row[some], last_row[some])
        at += some[0]
        up = row / triangles.rows[at]
        steps = np.ceil(triangles.columns[at] * (1.0 - up)).astype(np.int64)
        enter, leave = triangles.along_within(at, up, low_m, high_m)
        first = np.maximum(np.floor(enter * steps).astype(np.int64) - 1, 0)
        last = np.minimum(np.ceil(leave * steps).astype(np.int64) + 1, steps)
        met = np.flatnonzero(enter <= leave)
        for rows in _batches(last[met] - first[met] + 1, POINTS_AT_ONCE):
            of, column = _ranges(first[met[rows]], last[met[rows]])
            of = met[rows][of]
            along = np.where(column == steps[of], np.minimum(column, 1), column * (1.0 / np.maximum(steps[of], 1)))
            weights = np.stack([(1.0 - up[of]) * (1.0 - along), (1.0 - up[of]) * along, up[of]], axis=1)
            corners = (triangles.a, triangles.b, triangles.c)
            yield np.asarray(sum(weights[:, k, None] * corners[k][at[of]] for k in range(3)), np.float64)


def _batches(counts: NDArray[np.int64], limit: int) -> list[NDArray[np.int64]]:
    """Cut the indices of counts (n,) into runs that add up to about the limit each, or are one."""
    run = np.cumsum(counts) // limit
    return [some for some in np.split(np.arange(len(counts)), np.flatnonzero(np.diff(run)) + 1) if len(some)]


def _ranges(first: NDArray[np.int64], last: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return every integer of the ranges first..last (n,), one range after the other, behind its range's index."""
    counts = last - first + 1
    of = np.repeat(np.arange(len(counts)), counts)
    return of, np.arange(len(of)) - np.repeat(np.cumsum(counts) - counts - first, counts)
