"""run_fleet: surveys a large area in tiles on many workers, merges their maps and scores the result."""

from __future__ import annotations

import heapq
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from uwsim.base.atomic_file import write_atomically
from uwsim.base.folder_lock import alone_in
from uwsim.base.options import require_within
from uwsim.campaigns.fleet.score import scored
from uwsim.campaigns.fleet.tile_job import TileJob, start_above
from uwsim.campaigns.fleet.tiles import TILES, Grid, Tile, grid_over, tiles_of
from uwsim.campaigns.sweeps.job import fly_job
from uwsim.campaigns.workers import Campaign, Finished, Ledger, RetriedOptions
from uwsim.campaigns.workers.work import Show
from uwsim.flight.flyable_lanes import require_lanes_flown_by, required_survey
from uwsim.flight.folder import made_folder
from uwsim.mapping import OccupancyMap
from uwsim.mapping.merge import merge_files
from uwsim.scenario import Scenario, ScenarioError, build_terrain, load
from uwsim.scenario.fingerprint import build_fingerprint, scenario_fingerprint
from uwsim.scoring.score_text import write_json
from uwsim.simulator.simulator import Simulator

MAP, SUMMARY, FIGURE = "map.bt", "summary.json", "tiles.png"
LIMITS = {"tile_m": (1.0, 1e5, "m"), "vehicles": (1, 100_000, ""), "voxel_m": (0.02, 10.0, "m")}


@dataclass(frozen=True, eq=False)
class Fleet:
    """A survey of an area in tiles, complete or in progress.

    results: keyed by tile number, without those of tiles that are too shallow to fly in. figures: values for the whole
    area. interrupted: whether tiles or the score are missing; `resume=True` continues the survey.
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
        flown = {number: result["metrics"] for number, result in self.results.items()}
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
    **options: Any,
) -> Fleet:
    """Survey a scenario's area in tiles of about tile_m; write `out`/map.bt, summary.json and tiles.png.

    Each tile has its own starting position, and is surveyed by a copy of the scenario's first vehicle in that part of
    the terrain. voxel_m, seed: override the values in the scenario. vehicles: number of vehicles that share the tiles;
    affects the fleet's total time but not the map. options: as for uwsim.campaigns.sweeps.run_sweep. Raises
    ScenarioError, ValueError or OSError.
    """
    campaign = Campaign(RetriedOptions, **options)
    base = load(scenario)
    survey = required_survey(base)
    edge_m = survey.voxel_m if voxel_m is None else voxel_m
    for name, value in (("tile_m", tile_m), ("vehicles", vehicles), ("voxel_m", edge_m)):
        require_within(name, value, *LIMITS[name])
    if base.terrain.window_m is not None:
        raise ScenarioError("terrain.window_m: must be left out for a fleet: each tile has its own")
    if base.faults:
        raise ScenarioError("faults: must be left out for a fleet: each tile has a vehicle of its own")
    grid = grid_over(survey.area_m, tile_m)
    tiles, left_m2 = tiles_of(survey.area_m, grid, edge_m)
    plan = {
        "scenario": scenario_fingerprint(base), "tile_m": tile_m, "voxel_m": edge_m,
        "seed": base.seed if seed is None else seed, "build": build_fingerprint(),
    }  # fmt: skip
    with campaign.show("checking the tiles"):
        jobs = _jobs(scenario, base, tiles, plan)
    into = made_folder(Path(out), (SUMMARY, FIGURE, MAP))
    with alone_in(into):
        (into / TILES).mkdir(exist_ok=True)
        with Ledger.opened(into, plan, resume=campaign.options.resume, what="fleet", jobs="tiles") as ledger:
            results = ledger.results

            def kept(each: Finished) -> dict[str, Any]:
                """Write the tile's files and return the rest of its result."""
                result = dict(each.result or {"metrics": {}, "error": each.error})
                for key, suffix in (("map", ".ot"), ("path", ".npy")):
                    if key in result:
                        write_atomically(jobs[each.job].tile.file(into, suffix), result.pop(key))
                return result

            campaign.run(ledger, fly_job, jobs, result_of=kept)
        if len(results) < len(jobs):
            return Fleet(into, tiles, results, {}, interrupted=True)
        flown = {number: jobs[number] for number in sorted(results) if not results[number]["error"]}
        figures = _flown_figures(base, grid, tiles, left_m2, results, plan, vehicles)
        figures |= _merged(into, [job.tile.file(into, ".ot") for job in flown.values()], campaign.show)
        scores: Mapping[int, Mapping[str, Any]] = {}
        if score:
            range_m = max(float(results[number]["range_m"]) for number in flown)
            with campaign.show("scoring the map"):
                found = scored(campaign, flown, grid, range_m, into, into / MAP)
            if found is None:
                return Fleet(into, tiles, results, figures, interrupted=True)
            figures, scores = figures | found[0], found[1]
        write_json(into / SUMMARY, figures)
        with campaign.show("drawing the tiles"):
            from uwsim.campaigns.fleet.figure import draw_fleet  # imported here, since matplotlib takes a second

            draw_fleet(into / FIGURE, into / MAP, tiles, results, scores, figures)
        return Fleet(into, tiles, results, figures)


def _jobs(scenario: str | Path, base: Scenario, tiles: list[Tile], plan: Mapping[str, Any]) -> dict[int, TileJob]:
    """Return the jobs of all tiles with water deep enough to fly in, once the first of them can be flown.

    Raises its error, or ScenarioError if there is none.
    """
    name = str(Path(scenario).resolve()) if Path(scenario).is_file() else str(scenario)
    terrain = build_terrain(base.terrain)
    starts = {tile.number: start_above(terrain, tile) for tile in tiles}
    jobs = {
        tile.number: TileJob(name, plan["seed"], {}, voxel_m=plan["voxel_m"], tile=tile, start_m=start)
        for tile in tiles
        if (start := starts[tile.number]) is not None
    }
    if not jobs:
        raise ScenarioError("survey.area_m: there is no tile with water deep enough to fly in")
    require_lanes_flown_by(Simulator(next(iter(jobs.values())).varied_scenario(), threads=1))
    return jobs


def _flown_figures(
    base: Scenario, grid: Grid, tiles: list[Tile], left_m2: float, results: Mapping[int, Mapping[str, Any]],
    plan: Mapping[str, Any], vehicles: int,
) -> dict[str, Any]:  # fmt: skip
    flown = [result["metrics"] for _, result in sorted(results.items()) if not result["error"]]
    times_s = [float(metrics["simulated_s"]) for metrics in flown]
    sums = ("pings", "echoes", "path_length_m", "collisions", "lanes.flown_m", "lanes.planned_m")
    return {
        "scenario": base.name,
        **{key: plan[key] for key in ("seed", "voxel_m", "build")},
        "tile_edge_m": list(grid.edge_m),
        "tiles": len(tiles),
        "tiles_flown": len(flown),
        "tiles_dry": len(tiles) - len(results),
        "tiles_ended_early": sum(bool(metrics.get("ended_early")) for metrics in flown),
        "tiles_failed": len(results) - len(flown),
        "area_left_out_m2": left_m2,
        **{key.replace(".", "_"): sum(metrics[key] for metrics in flown) for key in sums},
        "simulated_s": sum(times_s),
        "vehicles": vehicles,
        "fleet_out_s": max(shares(times_s, vehicles), default=0.0),
        "fly_worker_s": sum(float(result.get("run_wall_s", 0.0)) for result in results.values()),
        "fly_cpu_s": sum(float(result.get("run_cpu_s", 0.0)) for result in results.values()),
    }


def shares(times_s: list[float], vehicles: int) -> list[float]:
    """Return each vehicle's working time if the longest tile goes to the first free vehicle (LPT; Graham 1969).

    Transits between tiles are not included.
    """
    busy = [0.0] * min(vehicles, max(len(times_s), 1))
    for time_s in sorted(times_s, reverse=True):
        heapq.heapreplace(busy, busy[0] + time_s)
    return sorted(busy, reverse=True)


def _merged(into: Path, maps: list[Path], show: Show) -> dict[str, Any]:
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
