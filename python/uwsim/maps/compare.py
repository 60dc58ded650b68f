"""Where two maps of one grid differ in state, and a picture of it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.figure_style import FAINT_INK, add_legend, dress, new_figure, save_figure
from uwsim.mapping import OccupancyMap
from uwsim.maps.files import require_same_grid

STATES = ("occupied", "free", "unknown")
_STATE_CODES = (1, 0, -1)
AT_ONCE = 1 << 22
WIDTH_IN = 9.6
BOTH, ONLY_FIRST, ONLY_SECOND = "#c9d1d8", "#d55e00", "#0072b2"  # vermilion and blue of Okabe and Ito's palette


@dataclass(frozen=True, eq=False)
class MapDifference:
    """How the voxels of one map stand in another.

    counts: (3, 3) int64, voxels by their state in the first (row) and the second (column) in the order of STATES;
    unknown to both is not counted: 0. only_first_m, only_second_m, both_m: (n, 3), centres occupied in the first alone,
    in the second alone, in both, world.
    """

    counts: NDArray[np.int64]
    only_first_m: NDArray[np.float64]
    only_second_m: NDArray[np.float64]
    both_m: NDArray[np.float64]
    resolution_m: float

    @property
    def differing(self) -> int:
        """Voxels that are of another state in the second."""
        return int(self.counts.sum() - np.trace(self.counts))


def difference(first: OccupancyMap, second: OccupancyMap) -> MapDifference:
    """Compare voxel by voxel. Raises ValueError unless the maps are of one resolution and origin."""
    require_same_grid(first, second)
    counts = np.zeros((3, 3), np.int64)
    occupied, in_second = first.occupied_voxels(), np.empty(0, np.int8)
    in_second = _states(second, occupied)
    counts[0] = [np.count_nonzero(in_second == code) for code in _STATE_CODES]
    in_second_free = _states(second, first.free_voxels())
    counts[1] = [np.count_nonzero(in_second_free == code) for code in _STATE_CODES]
    other = second.occupied_voxels()
    in_first = _states(first, other)
    counts[2, 0] = np.count_nonzero(in_first == -1)
    counts[2, 1] = np.count_nonzero(_states(first, second.free_voxels()) == -1)
    return MapDifference(
        counts, occupied[in_second != 1], other[in_first != 1], occupied[in_second == 1], first.resolution_m
    )


def draw_difference(path: Path, found: MapDifference, names: tuple[str, str]) -> None:
    """Draw from above the columns of voxels in which a map alone, or both, hold something occupied."""
    everything = np.concatenate([found.only_first_m, found.only_second_m, found.both_m])
    if not len(everything):
        raise ValueError("neither map has an occupied voxel: there is nothing to draw")
    low = everything[:, :2].min(axis=0) - found.resolution_m
    high = everything[:, :2].max(axis=0) + found.resolution_m
    size = high - low
    figure = new_figure(WIDTH_IN, WIDTH_IN * float(np.clip(size[1] / size[0], 0.25, 2.0)))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    dress(axes, f"{found.differing:,} voxels differ in state", "east [m]", "north [m]")
    axes.set_aspect("equal")
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    layers = (
        (found.both_m, BOTH, "occupied in both"),
        (found.only_first_m, ONLY_FIRST, f"only in {names[0]}"),
        (found.only_second_m, ONLY_SECOND, f"only in {names[1]}"),
    )
    for order, (centres, colour, name) in enumerate(layers):
        _draw_columns(axes, centres, found.resolution_m, colour, order)
        style: dict[str, Any] = {"s": 40, "marker": "s", "linewidths": 0}
        axes.scatter([], [], color=colour, label=f"{name}: {len(centres):,} voxels", **style)
    if not len(found.only_first_m) and not len(found.only_second_m):
        axes.text(0.5, 0.02, "the same voxels are occupied", transform=axes.transAxes, ha="center", color=FAINT_INK)
    add_legend(axes, 3)
    save_figure(figure, path)


def _draw_columns(axes: Any, centres_m: NDArray[np.float64], resolution_m: float, colour: str, order: int) -> None:
    """Paint the squares under voxels."""
    if not len(centres_m):
        return
    corner = centres_m[:, :2].min(axis=0) - resolution_m / 2.0
    at = np.round((centres_m[:, :2] - corner) / resolution_m - 0.5).astype(np.int64)
    columns, rows = at.max(axis=0) + 1
    mask = np.zeros((rows, columns, 4), np.float32)
    rgb = [int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5)]
    mask[at[:, 1], at[:, 0]] = [*rgb, 1.0]
    extent = (corner[0], corner[0] + columns * resolution_m, corner[1], corner[1] + rows * resolution_m)
    axes.imshow(mask, origin="lower", extent=extent, interpolation="nearest", zorder=order)
    axes.set_autoscale_on(False)


def _states(occupancy: OccupancyMap, centres_m: NDArray[np.float64]) -> NDArray[np.int8]:
    """state_at, a part at a time."""
    parts = [occupancy.state_at(centres_m[start : start + AT_ONCE]) for start in range(0, len(centres_m), AT_ONCE)]
    return np.concatenate([np.empty(0, np.int8), *parts])
