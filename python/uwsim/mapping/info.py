"""Describes a map file: format, size, resolution, counts and bounds."""

from __future__ import annotations

from pathlib import Path

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
