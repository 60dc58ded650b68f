"""The content of a fleet's folder: the map, and for each tile its own map and the positions of its pings."""

from __future__ import annotations

from pathlib import Path

MAP, TILES = "map.bt", "tiles"


def map_file(out: Path, tile: int) -> Path:
    """Return the path of a tile's map, with all its log-odds."""
    return out / TILES / f"{tile:06d}.ot"


def path_file(out: Path, tile: int) -> Path:
    """Return the path of a tile's positions (n, 3) float32, of the sonar at each ping."""
    return out / TILES / f"{tile:06d}.npy"


def scores_file(out: Path) -> Path:
    """Return the path of the tiles' scores."""
    return out / TILES / "scores.json"
