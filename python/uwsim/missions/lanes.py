"""Parallel lanes that cover a polygon, as a lawn-mower flies them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Point = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Lane:
    """A straight line to fly, from start_m to end_m, each (2,)."""

    start_m: Point
    end_m: Point

    @cached_property
    def length_m(self) -> float:
        """Distance from start to end."""
        return float(np.linalg.norm(self.end_m - self.start_m))

    @cached_property
    def heading_rad(self) -> float:
        """Direction of the lane from east, counter-clockwise."""
        return math.atan2(self.direction[1], self.direction[0])

    @cached_property
    def direction(self) -> Point:
        """Unit vector from start to end."""
        return (self.end_m - self.start_m) / self.length_m

    def locate(self, point_m: Point) -> tuple[float, float]:
        """Return (along, across) of a point: metres past the start, metres to port of the line."""
        along_x, along_y, start_x, start_y = self._line
        dx, dy = float(point_m[0]) - start_x, float(point_m[1]) - start_y
        return along_x * dx + along_y * dy, along_x * dy - along_y * dx

    @cached_property
    def _line(self) -> tuple[float, ...]:
        """Direction and start as plain numbers, which are faster than arrays in a control loop."""
        return (*self.direction.tolist(), *np.asarray(self.start_m, np.float64).tolist())


def lawn_mower_lanes(
    area_m: Sequence[Sequence[float]] | Point, spacing_m: float, run_out_m: float, near_m: Point
) -> list[Lane]:
    """Cover a simple polygon with parallel lanes, flown back and forth from the corner nearest to near_m.

    The lanes run along the polygon's longest edge, at most spacing_m apart and half of that from its sides, and extend
    run_out_m past it at both ends, so that a forward-looking sonar sees the polygon's rim.
    Raises ValueError if no lane fits.
    """
    area = np.asarray(area_m, np.float64)
    edges = np.roll(area, -1, axis=0) - area
    along = max(edges, key=np.linalg.norm)
    along = along / np.linalg.norm(along)
    across = np.array([-along[1], along[0]])
    low, high = (area @ across).min(), (area @ across).max()
    count = max(1, int(np.ceil((high - low) / spacing_m)))
    offsets = low + (np.arange(count) + 0.5) * (high - low) / count
    spans = [(offset, _span(area @ along, area @ across, offset)) for offset in offsets]
    lanes = [
        Lane((first - run_out_m) * along + offset * across, (last + run_out_m) * along + offset * across)
        for offset, (first, last) in spans
        if last > first
    ]
    if not lanes:
        raise ValueError(f"survey.area_m = {area.tolist()} m: no lane fits into it")
    return _back_and_forth(lanes, near_m)


def _span(along: Point, across: Point, offset: float) -> tuple[float, float]:
    """Return where the line at `offset` enters and leaves the polygon, given its corners along and across the lanes."""
    crossings = []
    for k in range(len(along)):
        a, b = across[k - 1], across[k]
        if (a < offset) != (b < offset):
            crossings.append(along[k - 1] + (offset - a) / (b - a) * (along[k] - along[k - 1]))
    return (min(crossings), max(crossings)) if crossings else (0.0, 0.0)


def _back_and_forth(lanes: list[Lane], near_m: Point) -> list[Lane]:
    """Order and turn the lanes so that the first starts nearest to near_m and each next one where the last ended."""

    def reversed_lane(lane: Lane) -> Lane:
        return Lane(lane.end_m, lane.start_m)

    def distance(lane: Lane) -> float:
        return float(np.linalg.norm(lane.start_m - near_m))

    candidates = (lanes, [reversed_lane(lane) for lane in lanes])
    ordered = min((order for c in candidates for order in (c, c[::-1])), key=lambda order: distance(order[0]))
    return [lane if k % 2 == 0 else reversed_lane(lane) for k, lane in enumerate(ordered)]
