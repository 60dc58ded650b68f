"""Slices through a map: the states of a horizontal or vertical layer of voxels."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from uwsim.mapping.occupancy_map import OccupancyMap

Axis = Literal["x", "y", "z"]
MAX_CELLS = 64_000_000


@dataclass(frozen=True, eq=False)
class MapSlice:
    """States (rows, columns) int8 in a plane: 1 occupied, 0 free, -1 unknown. Rows run along `up`, from low to high.

    axis: the plane's normal. at_m: coordinate of the layer's middle. across, up: the axes of the columns and of the
    rows. extent_m: low and high ends along `across`, then along `up`.
    """

    states: NDArray[np.int8]
    axis: Axis
    at_m: float
    across: Axis
    up: Axis
    extent_m: tuple[float, float, float, float]


def slice_map(occupancy: OccupancyMap, axis: Axis, at_m: float) -> MapSlice:
    """Return the layer of voxels that contains the plane axis = at_m, within the bounds of the known voxels.

    Raises ValueError if the map is empty, at_m is outside those bounds, or there are more than MAX_CELLS voxels.
    """
    if not np.isfinite(at_m):
        raise ValueError(f"{axis} = {at_m} m: must be finite")
    bounds = occupancy.bounds()
    if bounds is None:
        raise ValueError("the map is empty: there is nothing to slice")
    normal = "xyz".index(axis)
    (low, high), edge_m = bounds, occupancy.resolution_m
    if not low[normal] <= at_m < high[normal]:
        rule = f"must be in [{low[normal]:g}, {high[normal]:g}) m, the bounds of the map"
        raise ValueError(f"{axis} = {at_m:g} m: {rule}")
    first, second = (k for k in range(3) if k != normal)
    counts = np.round((high - low) / edge_m).astype(np.int64)
    if counts[first] * counts[second] > MAX_CELLS:
        raise ValueError(f"{counts[first]} x {counts[second]} voxels: must be at most {MAX_CELLS}")
    middle = float(low[normal] + (np.floor((at_m - low[normal]) / edge_m) + 0.5) * edge_m)
    states = np.empty((counts[second], counts[first]), np.int8)
    across = low[first] + (np.arange(counts[first]) + 0.5) * edge_m
    for row in range(counts[second]):
        points = np.empty((len(across), 3))
        points[:, first], points[:, second], points[:, normal] = across, low[second] + (row + 0.5) * edge_m, middle
        states[row] = occupancy.state_at(points)
    axes: tuple[Axis, Axis, Axis] = ("x", "y", "z")
    extent = (float(low[first]), float(high[first]), float(low[second]), float(high[second]))
    return MapSlice(states, axis, middle, axes[first], axes[second], extent)
