"""Triangles covered by grids of sample points, and the parts of those grids that lie in a box."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

ROWS_AT_ONCE, POINTS_AT_ONCE = 1 << 18, 1 << 20

Box = tuple[NDArray[np.float64], NDArray[np.float64]]


@dataclass(frozen=True, eq=False)
class SampledTriangles:
    """Triangles as grids of sample points, in rows parallel to the longest edge a-b that shrink towards the corner c.

    a, b, c: (m, 3), corners. low, high: (m, 3), bounding boxes. columns: (m,), steps along a-b. rows: (m,), steps from
    a-b to c. Neither rows nor points within a row are further apart than the spacing. Sorted by columns, then rows.
    """

    a: NDArray[np.float64]
    b: NDArray[np.float64]
    c: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    columns: NDArray[np.int64]
    rows: NDArray[np.int64]

    @classmethod
    def from_corners(cls, corners_m: NDArray[np.float64], spacing_m: float) -> Self:
        """Choose the grids for triangles with corners (m, 3, 3)."""
        lengths = np.linalg.norm(np.roll(corners_m, -1, axis=1) - corners_m, axis=2)
        turn = (lengths.argmax(axis=1)[:, None] + np.arange(3)) % 3
        a, b, c = np.moveaxis(np.take_along_axis(corners_m, turn[:, :, None], axis=1), 1, 0)
        base_m = lengths.max(axis=1, initial=0.0)
        area_m2 = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
        columns = np.ceil(base_m / spacing_m).astype(np.int64)
        rows = np.ceil(2.0 * area_m2 / np.maximum(base_m, 1e-12) / spacing_m).astype(np.int64)
        triangles = cls(a, b, c, corners_m.min(axis=1), corners_m.max(axis=1), columns, np.maximum(rows, 1))
        return triangles.at(np.lexsort((rows, columns)))

    def at(self, index: NDArray[np.int64]) -> Self:
        """Return the triangles at these indices."""
        corners = self.a[index], self.b[index], self.c[index]
        return type(self)(*corners, self.low[index], self.high[index], self.columns[index], self.rows[index])

    def touching(self, low_m: NDArray[np.float64], high_m: NDArray[np.float64]) -> Self:
        """Return the triangles whose bounding boxes meet the box."""
        touches = np.ones(len(self.a), bool)
        for axis in range(3):  # one column at a time is faster than rows of three
            touches &= (self.low[:, axis] <= high_m[axis]) & (self.high[:, axis] >= low_m[axis])
        return self.at(np.flatnonzero(touches))

    def heights_within(
        self, low_m: NDArray[np.float64], high_m: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return bounds (m,) on how far the parts in the box reach from edge a-b (0) towards corner c (1)."""
        along = (self.b - self.a) / np.maximum(np.linalg.norm(self.b - self.a, axis=1), 1e-12)[:, None]
        upright = self.c - self.a - np.einsum("ij,ij->i", self.c - self.a, along)[:, None] * along
        slope = upright / np.maximum(np.einsum("ij,ij->i", upright, upright), 1e-24)[:, None]
        middle = np.einsum("ij,ij->i", (low_m + high_m) / 2.0 - self.a, slope)
        reach = np.abs(slope) @ ((high_m - low_m) / 2.0)
        flat = self.rows < 4  # so flat that rounding dominates the slope
        lowest, highest = np.clip(middle - reach, 0.0, 1.0), np.clip(middle + reach, 0.0, 1.0)
        return np.where(flat, 0.0, lowest), np.where(flat, 1.0, highest)

    def along_within(
        self, at: NDArray[np.int64], up: NDArray[np.float64], low_m: NDArray[np.float64], high_m: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return where rows of triangles `at` (r,) enter and leave the box, as shares of the row; entry > exit: never.

        up: (r,), the rows' heights between edge a-b (0) and corner c (1).
        """
        enter, leave = np.zeros(len(at)), np.ones(len(at))
        for axis in range(3):
            a, b, c = self.a[at, axis], self.b[at, axis], self.c[at, axis]
            start, direction = (1.0 - up) * a + up * c, (1.0 - up) * (b - a)
            with np.errstate(divide="ignore", invalid="ignore"):
                one, other = (low_m[axis] - start) / direction, (high_m[axis] - start) / direction
            parallel = direction == 0.0
            beside = parallel & ((start < low_m[axis]) | (start > high_m[axis]))
            enter = np.where(parallel, enter, np.maximum(enter, np.minimum(one, other)))
            leave = np.where(parallel, leave, np.minimum(leave, np.maximum(one, other)))
            leave[beside] = -1.0
        return np.minimum(enter, 2.0), np.maximum(leave, -1.0)


def sample_points(
    triangles: SampledTriangles, low_m: NDArray[np.float64], high_m: NDArray[np.float64]
) -> Iterator[NDArray[np.float64]]:
    """Yield the sample points (n, 3) in the box, and a few outside, in batches of about POINTS_AT_ONCE."""
    lowest, highest = triangles.heights_within(low_m, high_m)
    first_row = np.maximum(np.floor(lowest * triangles.rows).astype(np.int64) - 1, 0)
    last_row = np.minimum(np.ceil(highest * triangles.rows).astype(np.int64) + 1, triangles.rows)
    for batch in _batches(last_row - first_row + 1, ROWS_AT_ONCE):
        at, row = _ranges(first_row[batch], last_row[batch])
        at += batch[0]
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
            up_of, corner = up[of], at[of]
            to_a, to_b = ((1.0 - up_of) * (1.0 - along))[:, None], ((1.0 - up_of) * along)[:, None]
            points = to_a * triangles.a[corner]
            points += to_b * triangles.b[corner]
            points += up_of[:, None] * triangles.c[corner]
            yield points


def _batches(counts: NDArray[np.int64], limit: int) -> list[NDArray[np.int64]]:
    """Split the indices of counts (n,) into runs whose counts add up to about the limit; no run is empty."""
    run = np.cumsum(counts) // limit
    return [part for part in np.split(np.arange(len(counts)), np.flatnonzero(np.diff(run)) + 1) if len(part)]


def _ranges(first: NDArray[np.int64], last: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the indices of the ranges first..last (n,), repeated, and every integer of each range in turn."""
    counts = last - first + 1
    of = np.repeat(np.arange(len(counts)), counts)
    return of, np.arange(len(of)) - np.repeat(np.cumsum(counts) - counts - first, counts)
