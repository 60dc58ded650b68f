"""A sweep of short surveys: runs per second, the overhead of a run over its flight, and the workers' memory over time.

Flight and whole run alternate in this process, by processor time; wall time and memory are those of a sweep.
"""

from __future__ import annotations

import statistics
import tempfile
import time
import warnings
from functools import partial
from typing import Annotated, Any

import psutil
import typer
from _harness import show, spent_s

from uwsim import Simulator
from uwsim.campaigns.sweeps import run_sweep
from uwsim.campaigns.sweeps.job import Job, fly_job
from uwsim.flight.flyable_lanes import SurveyAreaWarning
from uwsim.flight.survey import fly_survey
from uwsim.mapping import OccupancyMap
from uwsim.scoring.map_score import score_map

VARY = {
    "survey.altitude_m": {"low": 1.5, "high": 2.5},
    "survey.line_spacing_m": {"low": 2.0, "high": 4.0},
    "rov.drag.linear.surge": {"low": 20, "high": 60},
}
VOXEL_M = 0.5
SAMPLES = 10  # of memory


def main(
    scenario: Annotated[str, typer.Option(help="A scenario with a short survey.")] = "pool",
    runs: Annotated[int, typer.Option(min=20, help="Runs of the sweep.")] = 100,
    workers: Annotated[int, typer.Option(min=1, help="Number of worker processes.")] = 2,
    turns: Annotated[int, typer.Option(min=1, help="Pairs of a run and its flight that are measured here.")] = 30,
    mission_time: Annotated[
        float | None, typer.Option(help="Seconds after which the battery is empty, for shorter surveys.")
    ] = None,
) -> dict[str, Any]:
    """Compare a run with its flight, then measure a sweep."""
    always: dict[str, Any] = {} if mission_time is None else {"mission_time_s": mission_time}
    results = run_against_flight(scenario, turns, always) | whole_sweep(scenario, runs, workers, always)
    show(f"{runs:,} surveys of {scenario} on {workers} workers", results)
    return results


def run_against_flight(scenario: str, turns: int, always: dict[str, Any]) -> dict[str, float]:
    """Return the processor time of a run in a warm process, and that of its flight and score alone."""
    altitudes = ({"survey.altitude_m": 1.5 + seed / turns, **always} for seed in range(turns))
    jobs = [Job(scenario, seed, values, voxel_m=VOXEL_M) for seed, values in enumerate(altitudes)]
    fly_job(jobs[0])
    pairs = [(spent_s(partial(fly_job, job)), flight_cpu_s(job)) for job in jobs]
    return {
        "run_cpu_ms": 1e3 * statistics.median(run for run, _ in pairs),
        "flight_cpu_ms": 1e3 * statistics.median(flight for _, flight in pairs),
        "beside_flight_cpu_ms": 1e3 * statistics.median(run - flight for run, flight in pairs),
    }


def flight_cpu_s(job: Job) -> float:
    """Return the processor time of a run's flight and score alone, in an existing simulator."""
    sim = Simulator(job.varied_scenario(), threads=1)

    def fly() -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SurveyAreaWarning)
            occupancy, record = fly_survey(sim, OccupancyMap(resolution_m=VOXEL_M))
        path_m, area_m, range_m = record.path_world_m, record.area_world_m, record.range_max_m
        score_map(sim.world, occupancy.occupied_voxels(), VOXEL_M, path_m, area_m, range_m, rays=sim.scene)

    return spent_s(fly)


def whole_sweep(scenario: str, runs: int, workers: int, always: dict[str, Any]) -> dict[str, float]:
    """Return a sweep's wall time, the part of it not spent on flights, and the workers' memory [MB] at ten times."""
    same = {name: {"choices": [value]} for name, value in always.items()}
    sweep = {
        "scenario": scenario, "vary": VARY | same, "method": "latin_hypercube", "samples": runs, "voxel_m": VOXEL_M,
        "seeds": {"first": 0},
    }  # fmt: skip
    memory: dict[str, float] = {}
    times_s: list[float] = []

    def tell(finished: int, failed: int, count: int) -> None:
        times_s.append(time.perf_counter())
        if finished in {max(1, count * k // SAMPLES) for k in range(1, SAMPLES + 1)}:
            children = psutil.Process().children(recursive=True)
            sizes = sorted((child.memory_info().rss / 1e6 for child in children), reverse=True)[:workers]
            memory[f"largest worker after {finished} runs [MB]"] = sizes[0]

    with tempfile.TemporaryDirectory() as out:
        done = run_sweep(sweep, out, workers=workers, report=False, tell=tell)
    wall_s = times_s[-1] - times_s[0]
    flights_s, walls_s = done.rows.numbers("flight_wall_s"), done.rows.numbers("run_wall_s")
    return {
        "failed": done.failed,
        "runs_a_second": runs / wall_s,
        "run_wall_ms": 1e3 * statistics.median(walls_s),
        "beside_flight_wall_ms": 1e3 * statistics.median(walls_s - flights_s),
        "between_runs_wall_ms": 1e3 * (workers * wall_s - float(walls_s.sum())) / runs,
        **memory,
    }
