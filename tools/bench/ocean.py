"""The cost of an ocean model's fields and of tides: a step in them beside one in the same water with a uniform current.

All cases alternate within one run, so that other load affects them equally. Times are CPU times of the process, on one
thread, for a step of a vehicle that drifts: within a layer of the model, across one of its levels, or on a dive from
2 to 50 m.
"""

from __future__ import annotations

import itertools
import json
import statistics
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from _harness import alternated, console, goal_cells, new_table, ratio, spent_s

from uwsim import Simulator
from uwsim.scenario import Scenario
from uwsim.scenario.read.validated import validated

MOST = 1.3
PLACE = {"latitude_deg": 36.8065, "longitude_deg": -121.824}
LEVELS_M = (0.0, 5.0, 10.0, 20.0, 30.0, 50.0, 75.0)
CONSTITUENTS = ("M2", "S2", "K1", "O1")
TIDE = {"constituents": [{"constituent": name, "amplitude_m": 0.2, "phase_deg": 40} for name in CONSTITUENTS]}
TIDAL = [
    {"kind": "tide", "constituent": name, "major_m_s": 0.1, "minor_m_s": 0.02, "inclination_deg": 30}
    for name in CONSTITUENTS
]
DEPTHS_M = {
    "in a layer": np.array([15.0]), "across a level": np.array([20.0]), "on a dive": np.linspace(2.0, 50.0, 49),
}  # fmt: skip


def main(
    rounds: Annotated[int, typer.Option(min=1, help="Rounds; medians over them are reported.")] = 9,
    steps: Annotated[int, typer.Option(min=100, help="Steps of each case in a round.")] = 4000,
    vehicle: Annotated[list[str] | None, typer.Option(help="Vehicles to measure.")] = None,
) -> dict[str, Any]:
    """Measure all cases alternately and print the time of a step, and its ratio to one in a uniform current."""
    vehicles = vehicle or ["rov", "remus100", "bluerov2_heavy"]
    with tempfile.TemporaryDirectory() as folder:
        waters = waters_with(write_field(Path(folder) / "field.csv"))
        cases = {
            (model, where, water): case(model, waters[water], depths, steps)
            for (model, (where, depths), water) in itertools.product(vehicles, DEPTHS_M.items(), waters)
        }
    times = alternated(cases, rounds, warm_up=True)
    results: dict[str, Any] = {}
    table = new_table("A step of a vehicle", "vehicle", "depth", "water", "us", "of uniform", "goal", "met", texts=3)
    for (model, where, water), spent in times.items():
        step_s, of_uniform = statistics.median(spent), ratio(spent, times[model, where, "uniform"])
        results[f"{model}, {where}, {water}"] = {"step_s": step_s, "of_uniform": of_uniform}
        goal = goal_cells(of_uniform, MOST, at_most=True) if water != "uniform" else ("", "")
        table.add_row(model, where, water, f"{1e6 * step_s:.2f}", f"{of_uniform:.2f}", *goal)
    console.print(table)
    return results


def waters_with(field: Path) -> dict[str, dict[str, Any]]:
    """Return the scenario's water of each case; the first is what the others are compared with."""
    grid, profile = {"kind": "grid", "file": str(field)}, {"kind": "field", "file": str(field)}
    return {
        "uniform": {"salinity_psu": 33.5, "current_world_m_s": [0.1, 0.05, 0.0]},
        "current": {"salinity_psu": 33.5, "current": grid},
        "all fields": {"current": grid, "profile": profile},
        "fields and tide": {"current": [grid, *TIDAL], "profile": profile, "tide": TIDE},
    }


def write_field(path: Path) -> Path:
    """Write a field like that of a regional model: two times an hour apart, cells of 1.1 km, LEVELS_M."""
    rng = np.random.default_rng(0)
    axes = [
        np.array([0.0, 1.0]), np.array(LEVELS_M), PLACE["latitude_deg"] + 0.01 * np.arange(-4.5, 5.0),
        PLACE["longitude_deg"] + 0.0125 * np.arange(-4.5, 5.0),
    ]  # fmt: skip
    rows = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 4)
    depth_m = rows[:, 1]
    u, v, w = rng.normal(0.0, [[0.1], [0.1], [0.001]], (3, len(rows)))
    warm = 9.0 + 5.0 * np.exp(-depth_m / 20.0) + rng.normal(0.0, 0.05, len(rows))
    salt = 34.0 - 0.5 * np.exp(-depth_m / 20.0) + rng.normal(0.0, 0.01, len(rows))
    speeds = [f"{way}_sea_water_velocity_meter_per_sec" for way in ("eastward", "northward", "upward")]
    names = ["elapsed_time_hours", "depth_meter", "latitude_degree", "longitude_degree", *speeds,
             "sea_water_temperature_celsius", "sea_water_salinity_psu"]  # fmt: skip
    table = np.column_stack([rows, u, v, w, warm, salt])
    np.savetxt(path, table, "%.17g", ",", header=",".join(names), comments="")
    return path


def case(model: str, water: dict[str, Any], depths_m: np.ndarray, steps: int) -> Callable[[], float]:
    """Return a function that measures the time of a step of a vehicle that is placed at each of the depths."""
    scenario = {
        "name": "bench", "earth": PLACE, "water": water,
        "terrain": {"source": "noise", "size_m": [200, 200], "spacing_m": 2, "bed_depth_m": 70, "hill_height_m": 0},
        "vehicles": [{"name": "rov", "model": model, "start": {"position_m": [0, 0, -15]}}],
    }  # fmt: skip
    sim = Simulator(validated(Scenario, json.loads(json.dumps(scenario))))
    return partial(step_s, sim, depths_m, max(1, steps // len(depths_m)))


def step_s(sim: Simulator, depths_m: np.ndarray, steps: int) -> float:
    """Return the time of a step of a vehicle that drifts from each of these depths."""
    spent = 0.0
    for depth_m in depths_m.tolist():
        sim.rov.place((0.0, 0.0, -depth_m))
        spent += spent_s(lambda: sim.step(steps))
    return spent / (steps * len(depths_m))
