"""The names of the files in a fleet's folder: the merged map and, for each tile, its map and ping positions."""

from __future__ import annotations

from pathlib import Path

MAP, TILES = "map.bt", "tiles"


def map_file(out: Path, tile: int) -> Path:
    """Return the path of a tile's map, which keeps all log-odds."""
    return out / TILES / f"{tile:06d}.ot"


def path_file(out: Path, tile: int) -> Path:
    """Return the path of a tile's file with the sonar position at each ping, (n, 3) float32."""
    return out / TILES / f"{tile:06d}.npy"


def scores_file(out: Path) -> Path:
    """Return the path of the file with the scores of all tiles."""
    return out / TILES / "scores.json"
