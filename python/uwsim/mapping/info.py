"""The contents of a map: its description, a slice through it, and its occupied cubes for pictures."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from uwsim.mapping.files.formats import MAP_FORMATS, Origin
from uwsim.mapping.files.map_files import map_format, open_map
from uwsim.mapping.occupancy_map import OccupancyMap
from uwsim.mapping.voxel_keys import pack_keys, sorted_unique, unpack_keys, voxel_centres_m, voxel_keys


def map_info(path: Path, origin_world_m: Origin) -> list[tuple[str, str]]:
    """Return rows of (name, value with unit) about a map file. Raises OSError or ValueError if it cannot be read."""
    occupancy = open_map(path, origin_world_m)
    statistics, bounds = occupancy.statistics(), occupancy.bounds()
    edge_m, suffix = occupancy.resolution_m, map_format(path)
    rows = [
        ("file", str(path)),
        ("format", f"{suffix[1:]}, {MAP_FORMATS[suffix].content}"),
        ("bytes", f"{path.stat().st_size:,}"),
        ("resolution", f"{edge_m:g} m"),
        ("origin", " ".join(f"{x:.12g}" for x in occupancy.origin_world_m) + " m"),
        ("occupied voxels", f"{statistics.occupied_voxels:,} ({statistics.occupied_voxels * edge_m**3:,.1f} m3)"),
        ("free voxels", f"{statistics.free_voxels:,} ({statistics.free_voxels * edge_m**3:,.1f} m3)"),
        ("nodes", f"{statistics.nodes:,}"),
        ("memory", f"{statistics.memory_bytes / 1e6:,.1f} MB"),
    ]
    if bounds is None:
        return [*rows, ("bounds", "none: the map is empty")]
    for axis, low, high in zip("xyz", *bounds, strict=True):
        rows.append((f"known {axis}", f"{low:.2f} to {high:.2f} m ({high - low:.2f} m)"))
    return rows


def map_values(path: Path, origin_world_m: Origin) -> dict[str, Any]:
    """Return the same as values by name, in SI units; bounds_m is null for an empty map. Raises the same errors."""
    occupancy = open_map(path, origin_world_m)
    statistics, bounds = occupancy.statistics(), occupancy.bounds()
    return {
        "file": str(path),
        "format": map_format(path)[1:],
        "bytes": path.stat().st_size,
        "resolution_m": occupancy.resolution_m,
        "origin_world_m": occupancy.origin_world_m.tolist(),
        "occupied_voxels": statistics.occupied_voxels,
        "free_voxels": statistics.free_voxels,
        "nodes": statistics.nodes,
        "memory_bytes": statistics.memory_bytes,
        "bounds_m": None if bounds is None else [np.asarray(corner).tolist() for corner in bounds],
    }


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


def occupied_cubes(occupancy: OccupancyMap, name: str, most: int) -> tuple[NDArray[np.float64], float]:
    """Return the world centres (n, 3) and edge length [m] of at most `most` cubes, each of 1, 8, 64, ... voxels.

    A cube is occupied if a voxel in it is. name: the map's, for messages. Raises ValueError if no voxel is
    occupied, or more than 100 million are.
    """
    centres = occupancy.occupied_voxels()
    if not len(centres):
        raise ValueError(f"map '{name}': has no occupied voxels: there is nothing to draw")
    origin, edge_m = occupancy.origin_world_m, occupancy.resolution_m
    if len(centres) <= most:
        return centres, edge_m
    keys = sorted_unique(pack_keys(voxel_keys(centres - origin, edge_m)))
    while len(keys) > most:
        keys, edge_m = sorted_unique(pack_keys(unpack_keys(keys) >> 1)), 2.0 * edge_m
    return voxel_centres_m(unpack_keys(keys), edge_m) + origin, edge_m
