"""Plan views of maps, for notebooks and `map.view()`."""

from __future__ import annotations

import io
from typing import Protocol

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from uwsim.base.plain_figure import PlainFigure

SIZE_IN = (6.0, 5.0)
MOST_PIXELS = 1000  # along an edge


class Voxels(Protocol):
    """A map of voxels, such as an OccupancyMap."""

    @property
    def resolution_m(self) -> float:
        """The edge of a voxel."""

    def occupied_voxels(self) -> NDArray[np.float64]:
        """Return the centres (n, 3) of the occupied voxels."""


def plan_view(world: Voxels) -> Figure:
    """Return a figure of the highest occupied voxel in each column, coloured by height."""
    figure = PlainFigure(SIZE_IN, layout="constrained")
    axes = figure.add_subplot()
    voxels = world.occupied_voxels()
    title = f"{len(voxels):,} occupied voxels of {world.resolution_m:g} m"
    axes.set(aspect="equal", xlabel="east [m]", ylabel="north [m]", title=title)
    if len(voxels):
        heights, extent = highest(voxels, world.resolution_m)
        image = axes.imshow(heights, origin="lower", extent=extent, cmap="viridis", interpolation="nearest")
        figure.colorbar(image, label="height z [m]")
    return figure


def highest(
    voxels_m: NDArray[np.float64], edge_m: float
) -> tuple[NDArray[np.float64], tuple[float, float, float, float]]:
    """Return the greatest z in each cell, rows from south to north, NaN if empty, and (west, east, south, north).

    A cell is one voxel wide, or several in a large area.
    """
    low, high = voxels_m[:, :2].min(axis=0) - edge_m / 2, voxels_m[:, :2].max(axis=0) + edge_m / 2
    cell_m = edge_m * max(1, int(np.ceil((high - low).max() / edge_m / MOST_PIXELS)))
    columns, rows = np.ceil((high - low) / cell_m - 1e-9).astype(int)
    column, row = ((voxels_m[:, :2] - low) / cell_m).astype(int).T
    heights = np.full((rows, columns), -np.inf)
    np.maximum.at(heights, (row, column), voxels_m[:, 2])
    heights[np.isneginf(heights)] = np.nan
    west, south = low.tolist()
    return heights, (west, west + columns * cell_m, south, south + rows * cell_m)


def png(world: Voxels) -> bytes:
    """Return the figure from `plan_view` as a PNG file."""
    file = io.BytesIO()
    plan_view(world).savefig(file, format="png", dpi=100)
    return file.getvalue()
