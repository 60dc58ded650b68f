"""Jobs for a fleet's workers: the survey of a tile, as a run of a sweep, and the score of its part of the map."""

from __future__ import annotations

import io
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arrays import Floats
from uwsim.base.polygon import inside
from uwsim.campaigns.fleet.tiles import Grid, Tile
from uwsim.campaigns.sweeps.job import Job, flat, loaded, run_values
from uwsim.campaigns.workers.tidy import tidy_now_and_then
from uwsim.flight.flyable_lanes import required_survey
from uwsim.flight.survey import fly_survey
from uwsim.mapping.voxel_keys import unpack_keys, voxel_centres_m
from uwsim.scenario import Scenario, Terrain
from uwsim.scenario.read.validated import validated
from uwsim.scoring.map_score import MapScore, score_map
from uwsim.simulator.simulator import Simulator

MARGIN_M = 30.0
"""A margin added to the sonar's range, for lanes that begin outside the tile."""
START_Z_M, CLEAR_M = -1.5, 2.0
"""The z at which a vehicle is placed in the water, and the depth of water required below it."""


@dataclass(frozen=True, kw_only=True)
class TileJob(Job):
    """A tile to survey, from a place in the water. seed: determines the water and the noise of all vehicles."""

    tile: Tile
    start_m: tuple[float, float, float]

    def varied_scenario(self) -> Scenario:
        """Return the tile's scenario: its area, its part of the terrain, and one vehicle at the start.

        Each tile's vehicle has a different name, and thus different noise, in the same water. Raises ScenarioError.
        """
        base = loaded(self.scenario)
        survey, entry = required_survey(base), base.vehicles[0]
        data = {key: getattr(base, key) for key in type(base).model_fields if key != "faults"}
        data["terrain"] = {**dict(base.terrain), "window_m": window_m(base, np.array(self.tile.area_m))}
        data["survey"] = {**dict(survey), "area_m": self.tile.area_m, "voxel_m": self.voxel_m}
        name = f"{entry.name[:30]}_{self.tile.number}"
        data["vehicles"] = [{**dict(entry), "name": name, "start": {"position_m": self.start_m}}]
        return validated(Scenario, data).read_from(base.source_file).with_changes(seed=self.seed)

    def fly(self, sim: Simulator) -> dict[str, Any]:
        """Survey the tile; return its metrics, its map as .ot bytes, and its ping positions as .npy bytes."""
        occupancy, flown = fly_survey(sim, least_share=0.0)
        if flown.interrupted:
            raise KeyboardInterrupt  # the survey caught the error, but half a tile is not a result
        path = io.BytesIO()
        np.save(path, flown.path_world_m.astype(np.float32))
        return {
            "metrics": flat(run_values(flown)), "range_m": flown.range_max_m, "map": occupancy.to_bytes("ot"),
            "path": path.getvalue(),
        }  # fmt: skip


def start_above(terrain: Terrain, tile: Tile) -> tuple[float, float, float] | None:
    """Return a place in the water above a tile's deepest point; None if there is too little water to fly in."""
    area_m = np.array(tile.area_m)
    axes = [np.linspace(a, b, 41) for a, b in zip(area_m.min(axis=0), area_m.max(axis=0), strict=True)]
    places = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    places = np.concatenate([places[inside(places, area_m)], area_m.mean(axis=0)[None]])
    beds = np.nan_to_num(terrain.height_at(places), nan=0.0)
    deepest = int(np.argmin(beds))
    if beds[deepest] > START_Z_M - CLEAR_M:
        return None
    return float(places[deepest, 0]), float(places[deepest, 1]), START_Z_M


def window_m(base: Scenario, area_m: Floats) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return two opposite corners of the part of the terrain that a tile survey may see."""
    sonar = base.vehicles[0].sonar
    reach_m = MARGIN_M + sonar.loaded.band(sonar.frequency_hz).range_max_m
    (x0, y0), (x1, y1) = (area_m.min(axis=0) - reach_m).tolist(), (area_m.max(axis=0) + reach_m).tolist()
    limit = 10_000.0  # the limit for positions in a scenario
    return (max(x0, -limit), max(y0, -limit)), (min(x1, limit), min(y1, limit))


@dataclass(frozen=True, eq=False)
class ScoreJob:
    """The part of a merged map that belongs to a tile and is to be scored.

    occupied_m (n, 3): centres of occupied voxels. path_m (k, 3): sonar positions at pings in range.
    """

    job: TileJob
    grid: Grid
    occupied_m: NDArray[np.float32]
    path_m: NDArray[np.float32]
    range_m: float


def score_tile(job: ScoreJob) -> dict[str, Any]:
    """Return counts and sums for computing the score of the whole map; voxels on tile borders are counted once."""
    begun_s, begun_cpu_s = time.perf_counter(), time.process_time()
    counts = _counts(job)
    tidy_now_and_then(time.perf_counter() - begun_s)
    return {"error": None, **counts, "cpu_s": time.process_time() - begun_cpu_s}


def _counts(job: ScoreJob) -> dict[str, Any]:
    tile, edge_m = job.job.tile, job.job.voxel_m
    assert edge_m is not None
    with Simulator(job.job.varied_scenario(), threads=1) as sim:
        score: MapScore = score_map(
            sim.world, job.occupied_m.astype(np.float64), edge_m, job.path_m.astype(np.float64), np.array(tile.area_m),
            job.range_m, rays=sim.scene, occupied_were_seen=sim.rov.sonar.mode == "geometry",
        )  # fmt: skip
    centres = voxel_centres_m(unpack_keys(score.visible_voxels), score.resolution_m)
    own = (job.grid.cells_of(centres) == tile.cell).all(axis=1) if len(centres) else np.empty(0, bool)
    occupied = score.occupied_voxels
    return {
        "visible": int(own.sum()),
        "covered": int((score.covered & own).sum()),
        "occupied": occupied,
        "false": len(score.false_centres_m),
        "distance_sum_m": 0.0 if not occupied else float(score.distance_mean_m * occupied),
        "distance_p95_m": None if not occupied else score.distance_p95_m,
        "distance_max_m": None if not occupied else score.distance_max_m,
    }
