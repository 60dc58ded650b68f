"""Describes a map file: format, size, resolution, counts and bounds."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from uwsim.mapping.files.formats import MAP_FORMATS, Origin
from uwsim.mapping.files.map_files import map_format, open_map


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
