"""Tile-by-tile scoring of a fleet's map, so that no process needs the whole world."""

from __future__ import annotations

import json
import time
from collections import defaultdict
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.atomic_file import write_atomically
from uwsim.base.polygon import inside
from uwsim.campaigns.fleet.tile_job import ScoreJob, TileJob, score_tile
from uwsim.campaigns.fleet.tiles import TILES, Grid, Tile
from uwsim.campaigns.workers import Campaign
from uwsim.campaigns.workers.campaign import RETRIES
from uwsim.mapping import OccupancyMap

Floats = NDArray[np.float32]
SCORES = "scores.json"


class _ScoreJobs(Mapping[int, ScoreJob]):
    """The jobs that score the tiles, built one at a time to save memory, since several jobs may share a ping."""

    def __init__(self, jobs: Mapping[int, TileJob], grid: Grid, range_m: float, out: Path, occupied: Floats) -> None:
        """jobs: those of the flown tiles. occupied: centres (n, 3) of the occupied voxels of the merged map."""
        self._jobs, self._grid, self._range_m = jobs, grid, range_m
        self._path_m = np.concatenate([np.load(job.tile.file(out, ".npy")) for job in jobs.values()])
        self._of_tile = by_tile(occupied, grid, [job.tile for job in jobs.values()])
        self.unscored = len(occupied) - sum(map(len, self._of_tile.values()))

    def __len__(self) -> int:
        return len(self._jobs)

    def __iter__(self) -> Iterator[int]:
        return iter(self._jobs)

    def __getitem__(self, number: int) -> ScoreJob:
        job = self._jobs[number]
        area_m = np.array(job.tile.area_m)
        low, high = area_m.min(axis=0) - self._range_m, area_m.max(axis=0) + self._range_m
        near = ((self._path_m[:, :2] >= low) & (self._path_m[:, :2] <= high)).all(axis=1)
        return ScoreJob(job, self._grid, self._of_tile[number], self._path_m[near], self._range_m)


def by_tile(occupied_m: Floats, grid: Grid, tiles: list[Tile]) -> dict[int, Floats]:
    """Assign voxels (n, 3) to tiles by grid cell or, in a cell with several tiles, by tile outline."""
    codes = grid.cells_of(occupied_m) @ (grid.count[1], 1) if len(occupied_m) else np.empty(0, np.int64)
    order = np.argsort(codes, kind="stable")
    occupied_m, codes = occupied_m[order], codes[order]
    by_cell: dict[int, list[Tile]] = defaultdict(list)
    for tile in tiles:
        by_cell[tile.cell[0] * grid.count[1] + tile.cell[1]].append(tile)
    found = {}
    for code, there in by_cell.items():
        rest = occupied_m[np.searchsorted(codes, code) : np.searchsorted(codes, code, side="right")]
        for tile in there[1:]:
            within = inside(rest, np.array(tile.area_m))
            found[tile.number], rest = rest[within], rest[~within]
        found[there[0].number] = rest
    return found


def scored(
    campaign: Campaign, jobs: Mapping[int, TileJob], grid: Grid, range_m: float, out: Path, map_file: Path
) -> tuple[dict[str, Any], dict[int, dict[str, Any]]] | None:
    """Score each tile's part of the merged map on workers; return values for the whole map by name, and for each tile.

    jobs: those of the flown tiles. Returns None if the campaign was stopped. Raises OSError if a tile cannot be scored.
    """
    begun_s = time.perf_counter()
    wanted = _ScoreJobs(jobs, grid, range_m, out, OccupancyMap.read(map_file).occupied_voxels().astype(np.float32))
    parts: dict[int, dict[str, Any]] = {}
    with campaign.crew() as crew:
        for each in crew.finished(score_tile, wanted, retries=RETRIES, stop_requested=campaign.stop_requested):
            if each.result is None:
                raise OSError(f"tile {each.job}: cannot be scored: {each.why}")
            parts[each.job] = each.result
    if len(parts) < len(wanted):
        return None
    in_order = [parts[number] for number in sorted(parts)]
    total = {key: sum(part[key] for part in in_order) for key in ("visible", "covered", "occupied", "false")}
    write_atomically(out / TILES / SCORES, (json.dumps(parts, sort_keys=True) + "\n").encode())
    share = {
        "coverage": total["covered"] / total["visible"] if total["visible"] else None,
        "precision": 1.0 - total["false"] / total["occupied"] if total["occupied"] else None,
    }
    shares = [part["covered"] / part["visible"] for part in in_order if part["visible"]]
    sums = sum(part["distance_sum_m"] for part in in_order)
    values = {
        **share,
        "visible_truth_voxels": total["visible"],
        "occupied_voxels": total["occupied"] + wanted.unscored,
        "occupied_voxels_unscored": wanted.unscored,
        "false_voxels": total["false"],
        "distance_mean_m": sums / total["occupied"] if total["occupied"] else None,
        "distance_p95_of_the_worst_tile_m": max((p["distance_p95_m"] or 0.0 for p in in_order), default=None),
        "distance_max_m": max((p["distance_max_m"] or 0.0 for p in in_order), default=None),
        "coverage_of_the_worst_tile": min(shares, default=None),
        "score_cpu_s": sum(part["cpu_s"] for part in in_order),
        "score_s": time.perf_counter() - begun_s,
    }
    return values, parts
