"""What a map file holds, in words."""

from __future__ import annotations

from pathlib import Path

from uwsim.maps.files import Origin, bounds_of, map_format, open_map

FORMATS = {"bt": "bt, occupied or free", "ot": "ot, with all probabilities"}


def map_facts(path: Path, origin_world_m: Origin) -> list[tuple[str, str]]:
    """Return (what, value with unit). Raises OSError or ValueError as reading the map does."""
    occupancy = open_map(path, origin_world_m)
    statistics, bounds = occupancy.statistics(), bounds_of(occupancy)
    edge_m = occupancy.resolution_m
    facts = [
        ("file", str(path)),
        ("format", FORMATS[map_format(path)]),
        ("bytes", f"{path.stat().st_size:,}"),
        ("resolution", f"{edge_m:g} m"),
        ("occupied voxels", f"{statistics.occupied_voxels:,} ({statistics.occupied_voxels * edge_m**3:,.1f} m3)"),
        ("free voxels", f"{statistics.free_voxels:,} ({statistics.free_voxels * edge_m**3:,.1f} m3)"),
        ("nodes", f"{statistics.nodes:,}"),
        ("memory", f"{statistics.memory_bytes / 1e6:,.1f} MB"),
    ]
    if bounds is None:
        return [*facts, ("bounds", "none: the map is empty")]
    for axis, low, high in zip("xyz", bounds.low_m, bounds.high_m, strict=True):
        facts.append((f"known {axis}", f"{low:.2f} to {high:.2f} m ({high - low:.2f} m)"))
    return facts
