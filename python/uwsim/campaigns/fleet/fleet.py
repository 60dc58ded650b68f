"""run_fleet: surveys a large area in tiles on many workers, merges their maps and scores the result."""

from __future__ import annotations

import heapq
import time
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from uwsim.base.atomic_file import write_atomically
from uwsim.base.folder_lock import alone_in
from uwsim.campaigns.fleet.score import scored
from uwsim.campaigns.fleet.store import MAP, TILES, map_file, path_file
from uwsim.campaigns.fleet.tile_job import DryTileError, TileJob, fly_tile
from uwsim.campaigns.fleet.tiles import Grid, Tile, grid_over, tiles_of
from uwsim.campaigns.workers import Finished, Ledger, Show, Tell, open_workers, run_missing
from uwsim.flight.flyable_lanes import require_lanes_flown_by, required_survey
from uwsim.flight.folder import made_folder
from uwsim.mapping import OccupancyMap
from uwsim.mapping.merge import merge_files
from uwsim.scenario import Scenario, ScenarioError, load
from uwsim.scenario.fingerprint import build_fingerprint, scenario_fingerprint
from uwsim.scoring.score_json import write_json
from uwsim.simulator.simulator import Simulator

SUMMARY, FIGURE = "summary.json", "tiles.png"
RETRIES = 2


@dataclass(frozen=True, eq=False)
class Fleet:
    """A survey of an area in tiles, complete or in progress.

    results: keyed by tile number. figures: values for the whole area. interrupted: whether tiles or the score are
    missing; `resume=True` continues the survey.
    """

    out: Path
    tiles: list[Tile]
    results: Mapping[int, Mapping[str, Any]]
    figures: dict[str, Any]
    interrupted: bool = False

    @property
    def failed(self) -> dict[int, str]:
        """The errors of tiles that could not be surveyed, keyed by tile number."""
        return {number: str(result["error"]) for number, result in self.results.items() if result["error"]}

    @property
    def ended_early(self) -> dict[int, str]:
        """The reasons why the surveys of tiles ended before their last lane, keyed by tile number."""
        flown = {number: result["metrics"] for number, result in self.results.items() if "metrics" in result}
        return {number: str(of["ended_because"]) for number, of in flown.items() if of.get("ended_early")}


def run_fleet(
    scenario: str | Path,
    out: str | Path,
    *,
    tile_m: float,
    voxel_m: float | None = None,
    seed: int | None = None,
    vehicles: int = 1,
    score: bool = True,
    workers: int | None = None,
    scheduler: str | None = None,
    resume: bool = False,
    retry_failed: bool = False,
    stop_requested: Callable[[], bool] = lambda: False,
    tell: Tell = lambda finished, failed, count: None,
    show: Show = lambda activity: nullcontext(),
) -> Fleet:
    """Survey a scenario's area in tiles of about tile_m; write `out`/map.bt, summary.json and tiles.png.

    Each tile has its own starting position, and is surveyed by a copy of the scenario's first vehicle in that part of
    the terrain. voxel_m, seed: override the values in the scenario. vehicles: number of vehicles that share the tiles;
    affects the fleet's total time but not the map. workers, scheduler, resume, retry_failed: see
    uwsim.campaigns.sweeps.run_sweep. Raises ScenarioError, ValueError or OSError.
    """
    base = load(scenario)
    survey = required_survey(base)
    if not 1.0 <= tile_m <= 1e5:
        raise ValueError(f"tile_m = {tile_m:g} m: must be in [1, 100000] m")
    if not 1 <= vehicles <= 100_000:
        raise ValueError(f"vehicles = {vehicles}: must be in [1, 100000]")
    if base.terrain.window_m is not None:
        raise ScenarioError("terrain.window_m: must be left out for a fleet: each tile has its own")
    if base.faults:
        raise ScenarioError("faults: must be left out for a fleet: each tile has a vehicle of its own")
    edge_m = voxel_m if voxel_m is not None else survey.voxel_m
    if not 0.02 <= edge_m <= 10.0:
        raise ValueError(f"voxel_m = {edge_m:g} m: must be in [0.02, 10] m")
    grid = grid_over(survey.area_m, tile_m)
    tiles, left_m2 = tiles_of(survey.area_m, grid, edge_m)
    name = str(Path(scenario).resolve()) if Path(scenario).is_file() else str(scenario)
    jobs = {tile.number: TileJob(name, base.seed if seed is None else seed, tile, edge_m) for tile in tiles}
    with show("checking the tiles"):
        _require_flyable(base, jobs)
    plan = {
        "scenario": scenario_fingerprint(base), "tile_m": tile_m, "voxel_m": edge_m,
        "seed": base.seed if seed is None else seed, "build": build_fingerprint(),
    }  # fmt: skip
    if retry_failed and not resume:
        raise ValueError("retry_failed: needs resume")
    into = made_folder(Path(out), (SUMMARY, FIGURE, MAP))
    with alone_in(into):
        (into / TILES).mkdir(exist_ok=True)
        with Ledger.opened(into, plan, resume=resume, what="fleet", jobs="tiles") as ledger:
            with show("starting workers"):
                crew = open_workers(workers, scheduler=scheduler)
            with crew:
                missing = {n: job for n, job in jobs.items() if ledger.lacks(n, retry_failed=retry_failed)}
                for _ in run_missing(
                    crew, fly_tile, missing, len(jobs), ledger, retries=RETRIES,
                    result_of=partial(_result_of, into), stop_requested=stop_requested, tell=tell,
                ):  # fmt: skip
                    pass
                if len(ledger.results) < len(tiles):
                    return Fleet(into, tiles, ledger.results, {}, interrupted=True)
                figures = _flown_figures(base, grid, tiles, left_m2, ledger.results, plan, vehicles)
                figures |= _merged(into, ledger.results, show)
                if score:
                    with show("scoring the map"):
                        scores = scored(crew, jobs, grid, ledger.results, into, stop_requested)
                    if scores is None:
                        return Fleet(into, tiles, ledger.results, figures, interrupted=True)
                    figures |= scores
        write_json(into / SUMMARY, figures)
        with show("drawing the tiles"):
            from uwsim.campaigns.fleet.figure import draw_fleet  # imported here, since matplotlib takes a second

            draw_fleet(into / FIGURE, into / MAP, tiles, ledger.results, figures)
        return Fleet(into, tiles, ledger.results, figures)


def _require_flyable(base: Scenario, jobs: Mapping[int, TileJob]) -> None:
    """Build the scenario of the first tile that is not dry. Raises its error.

    Raises ScenarioError, too, if its vehicle cannot fly the survey's lanes, or if all tiles are dry.
    """
    for job in jobs.values():
        try:
            tile = job.scenario_of_tile(base)
        except DryTileError:
            continue
        return require_lanes_flown_by(Simulator(tile, threads=1))
    raise ScenarioError("survey.area_m: there is no tile with water deep enough to fly in")


def _result_of(into: Path, each: Finished) -> dict[str, Any]:
    """Write the tile's files and return the rest of its result."""
    result = dict(each.result or {"error": each.error, "dry": None})
    for key, file in (("map", map_file), ("path", path_file)):
        if key in result:
            write_atomically(file(into, each.job), result.pop(key))
    return result


def _flown_figures(
    base: Scenario, grid: Grid, tiles: list[Tile], left_m2: float, results: Mapping[int, Mapping[str, Any]],
    plan: Mapping[str, Any], vehicles: int,
) -> dict[str, Any]:  # fmt: skip
    flown = [result["metrics"] for result in results.values() if "metrics" in result]
    times_s = [float(metrics["simulated_s"]) for metrics in flown]
    return {
        "scenario": base.name,
        **{key: plan[key] for key in ("seed", "voxel_m", "build")},
        "tile_edge_m": list(grid.edge_m),
        "tiles": len(tiles),
        "tiles_flown": len(flown),
        "tiles_dry": sum(bool(result["dry"]) for result in results.values()),
        "tiles_ended_early": sum(bool(metrics.get("ended_early")) for metrics in flown),
        "tiles_failed": sum(bool(result["error"]) for result in results.values()),
        "area_left_out_m2": left_m2,
        **{key: sum(metrics[key] for metrics in flown) for key in ("pings", "echoes", "path_length_m", "collisions")},
        **{f"lanes_{key}": sum(metrics["lanes"][key] for metrics in flown) for key in ("flown_m", "planned_m")},
        "simulated_s": sum(times_s),
        "vehicles": vehicles,
        "fleet_out_s": max(shares(times_s, vehicles), default=0.0),
        "fly_worker_s": sum(float(result.get("wall_s", 0.0)) for result in results.values()),
        "fly_cpu_s": sum(float(result.get("cpu_s", 0.0)) for result in results.values()),
    }


def shares(times_s: list[float], vehicles: int) -> list[float]:
    """Return each vehicle's working time if the longest tile goes to the first free vehicle (LPT; Graham 1969).

    Transits between tiles are not included.
    """
    busy = [0.0] * min(vehicles, max(len(times_s), 1))
    for time_s in sorted(times_s, reverse=True):
        heapq.heapreplace(busy, busy[0] + time_s)
    return sorted(busy, reverse=True)


def _merged(into: Path, results: Mapping[int, Mapping[str, Any]], show: Show) -> dict[str, Any]:
    maps = [map_file(into, number) for number, result in sorted(results.items()) if "metrics" in result]
    if not maps:
        raise ValueError("no tile was surveyed: see the errors in the ledger")
    begun_s, begun_cpu_s = time.perf_counter(), time.process_time()
    with show(f"merging {len(maps):,} maps"):
        if len(maps) > 1:
            merge_files(maps, into / MAP)
        else:
            OccupancyMap.read(maps[0]).write(into / MAP)
    return {
        "merge_s": time.perf_counter() - begun_s,
        "merge_cpu_s": time.process_time() - begun_cpu_s,
        "tiles_bytes": sum(path.stat().st_size for path in maps),
        "map_bytes": (into / MAP).stat().st_size,
    }
