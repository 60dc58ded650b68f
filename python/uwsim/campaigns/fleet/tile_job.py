"""Jobs for a fleet's workers: surveying a tile, and scoring its part of the merged map."""

from __future__ import annotations

import io
import time
import warnings
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.campaigns.fleet.tiles import Grid, Tile
from uwsim.campaigns.workers.tidy import tidy
from uwsim.flight.flyable_lanes import SurveyAreaWarning, required_survey
from uwsim.flight.summary import flight_values
from uwsim.flight.survey import fly_survey
from uwsim.mapping import OccupancyMap
from uwsim.mapping.voxel_keys import unpack_keys, voxel_centres_m
from uwsim.scenario import Scenario, build_terrain, load
from uwsim.scenario.fingerprint import build_fingerprint, scenario_fingerprint
from uwsim.scenario.read.validated import validated
from uwsim.scoring.map_score import MapScore, score_map
from uwsim.scoring.polygon import inside_polygon
from uwsim.simulator.simulator import Simulator

MARGIN_M = 30.0
"""A margin added to the sonar's range, for lanes that begin outside the tile."""
START_Z_M, CLEAR_M = -1.5, 2.0
"""The z at which a vehicle is placed in the water, and the depth of water required below it."""


@dataclass(frozen=True)
class TileJob:
    """A tile to survey. scenario: a name or path. seed: determines the water and the noise of all vehicles."""

    scenario: str
    seed: int | None
    tile: Tile
    voxel_m: float

    def scenario_of_tile(self, base: Scenario) -> Scenario:
        """Return the tile's scenario: its area, its part of the terrain, and one vehicle above its deepest point.

        Each tile's vehicle has a different name, and thus different noise, in the same water. Raises ScenarioError.
        """
        survey, entry = required_survey(base), base.vehicles[0]
        window = window_m(base, np.array(self.tile.area_m))
        data = {key: getattr(base, key) for key in type(base).model_fields if key != "faults"}
        data["terrain"] = {**dict(base.terrain), "window_m": window}
        data["survey"] = {**dict(survey), "area_m": self.tile.area_m, "voxel_m": self.voxel_m}
        name = f"{entry.name[:30]}_{self.tile.number}"
        data["vehicles"] = [{**dict(entry), "name": name, "start": {"position_m": self._start_m(base)}}]
        return validated(Scenario, data).read_from(base.source_file)

    def _start_m(self, base: Scenario) -> tuple[float, float, float]:
        area_m = np.array(self.tile.area_m)
        terrain = _terrain(self.scenario)
        low, high = area_m.min(axis=0), area_m.max(axis=0)
        axes = [np.linspace(a, b, 41) for a, b in zip(low, high, strict=True)]
        places = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
        places = np.concatenate([places[inside_polygon(places, area_m)], area_m.mean(axis=0)[None]])
        beds = np.nan_to_num(terrain.height_at(places), nan=0.0)
        deepest = int(np.argmin(beds))
        if beds[deepest] > START_Z_M - CLEAR_M:
            raise DryTileError(f"its deepest place is {max(-beds[deepest], 0.0):.1f} m deep")
        return float(places[deepest, 0]), float(places[deepest, 1]), START_Z_M


class DryTileError(ValueError):
    """The water in a tile is too shallow to fly in."""


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


@lru_cache(maxsize=2)
def _loaded(scenario: str) -> Scenario:
    return load(scenario)


@lru_cache(maxsize=1)
def _terrain(scenario: str) -> Any:
    return build_terrain(_loaded(scenario).terrain)


def window_m(base: Scenario, area_m: NDArray[np.float64]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return two opposite corners of the part of the terrain that a tile survey may see."""
    sonar = base.vehicles[0].sonar
    reach_m = MARGIN_M + sonar.loaded.band(sonar.frequency_hz).range_max_m
    (x0, y0), (x1, y1) = (area_m.min(axis=0) - reach_m).tolist(), (area_m.max(axis=0) + reach_m).tolist()
    limit = 10_000.0  # the limit for positions in a scenario
    return (max(x0, -limit), max(y0, -limit)), (min(x1, limit), min(y1, limit))


def fly_tile(job: TileJob) -> dict[str, Any]:
    """Survey a tile; return its values, its map as .ot bytes, and its ping positions as .npy bytes.

    The result has `dry` set for a tile without enough water, and `error` for a tile that failed. Raises OSError or
    MemoryError.
    """
    begun_s, begun_cpu_s = time.perf_counter(), time.process_time()
    result: dict[str, Any] = {"error": None, "dry": None, "build": build_fingerprint()}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SurveyAreaWarning)  # the values contain lanes_left_out
            _fly(job, result)
    except (OSError, MemoryError):
        raise
    except DryTileError as dry:
        result["dry"] = str(dry)
    except Exception as error:
        result["error"] = f"{type(error).__name__}: {' '.join(str(error).split())}"
    tidy()
    return {**result, "wall_s": time.perf_counter() - begun_s, "cpu_s": time.process_time() - begun_cpu_s}


def _fly(job: TileJob, result: dict[str, Any]) -> None:
    scenario = job.scenario_of_tile(_loaded(job.scenario)).with_changes(seed=job.seed)
    sim = Simulator(scenario, threads=1)
    occupancy = OccupancyMap(resolution_m=job.voxel_m)
    _, record = fly_survey(sim, occupancy, least_share=0.0)
    if record.interrupted:
        raise KeyboardInterrupt  # the survey caught the error, but half a tile is not a result
    path = io.BytesIO()
    np.save(path, record.path_world_m.astype(np.float32))
    result |= {
        "metrics": flight_values(record),
        "scenario_digest": scenario_fingerprint(sim.scenario),
        "range_m": record.range_max_m,
        "map": occupancy.to_bytes("ot"),
        "path": path.getvalue(),
    }


def score_tile(job: ScoreJob) -> dict[str, Any]:
    """Return counts and sums for computing the score of the whole map; voxels on tile borders are counted once."""
    begun_cpu_s = time.process_time()
    scenario = job.job.scenario_of_tile(_loaded(job.job.scenario))
    sim = Simulator(scenario, threads=1)
    tile = job.job.tile
    score = score_map(
        sim.world, job.occupied_m.astype(np.float64), job.job.voxel_m, job.path_m.astype(np.float64),
        np.array(tile.area_m), job.range_m, rays=sim.scene, occupied_were_seen=sim.rov.sonar.mode == "geometry",
    )  # fmt: skip
    counts = _counts(score, tile, job.grid)
    del sim, score
    tidy()
    return {"error": None, **counts, "cpu_s": time.process_time() - begun_cpu_s}


def _counts(score: MapScore, tile: Tile, grid: Grid) -> dict[str, Any]:
    centres = voxel_centres_m(unpack_keys(score.visible_voxels), score.resolution_m)
    own = (grid.cells_of(centres) == tile.cell).all(axis=1) if len(centres) else np.empty(0, bool)
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
