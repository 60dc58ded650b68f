"""The cost of an ocean model's fields and of tides: a step in them beside one in the same water with a uniform current.

CPU times of a step of a vehicle that drifts: within a layer of the model, across a level, or on a dive from 2 to 50 m.
"""

from __future__ import annotations

import tempfile
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from _harness import Case, Rounds, beside, flat_water, spent_s

from uwsim import Simulator

MOST = 1.3
PLACE = {"latitude_deg": 36.8065, "longitude_deg": -121.824}
LEVELS_M = (0.0, 5.0, 10.0, 20.0, 30.0, 50.0, 75.0)
CONSTITUENTS = ("M2", "S2", "K1", "O1")
TIDE = {"constituents": [{"constituent": name, "amplitude_m": 0.2, "phase_deg": 40} for name in CONSTITUENTS]}
TIDAL = [
    {"kind": "tide", "constituent": name, "major_m_s": 0.1, "minor_m_s": 0.02, "inclination_deg": 30}
    for name in CONSTITUENTS
]
DEPTHS_M = {"in a layer": [15.0], "across a level": [20.0], "on a dive": np.linspace(2.0, 50.0, 49).tolist()}


def main(
    rounds: Rounds = 9,
    steps: Annotated[int, typer.Option(min=100, help="Steps of each case in a round.")] = 4000,
    vehicle: Annotated[list[str] | None, typer.Option(help="Vehicles to measure.")] = None,
) -> dict[str, Any]:
    """Measure all cases alternately and print the time of a step, and its ratio to one in a uniform current."""
    cases: dict[str, Case] = {}
    with tempfile.TemporaryDirectory() as folder:
        waters = waters_with(write_field(Path(folder) / "field.csv"))
        for model in vehicle or ["rov", "remus100", "bluerov2_heavy"]:
            for water, keys in waters.items():
                rov = {"model": model, "start": {"position_m": [0, 0, -15]}}
                sim = flat_water([rov], 70.0, earth=PLACE, water=keys)
                for where, depths_m in DEPTHS_M.items():
                    cases[f"{model}, {where}, {water}"] = partial(step_s, sim, depths_m, steps)
    return beside("a step", cases, rounds, lambda name: f"{name.rsplit(', ', 1)[0]}, uniform", MOST)


def waters_with(field: Path) -> dict[str, dict[str, Any]]:
    """Return the scenario's water of each case."""
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
    u, v, w = rng.normal(0.0, [[0.1], [0.1], [0.001]], (3, len(rows)))
    warm = 9.0 + 5.0 * np.exp(-rows[:, 1] / 20.0) + rng.normal(0.0, 0.05, len(rows))
    salt = 34.0 - 0.5 * np.exp(-rows[:, 1] / 20.0) + rng.normal(0.0, 0.01, len(rows))
    speeds = [f"{way}_sea_water_velocity_meter_per_sec" for way in ("eastward", "northward", "upward")]
    names = ["elapsed_time_hours", "depth_meter", "latitude_degree", "longitude_degree", *speeds,
             "sea_water_temperature_celsius", "sea_water_salinity_psu"]  # fmt: skip
    np.savetxt(path, np.column_stack([rows, u, v, w, warm, salt]), "%.17g", ",", header=",".join(names), comments="")
    return path


def step_s(sim: Simulator, depths_m: list[float], steps: int) -> float:
    """Return the time of a step of a vehicle that drifts from each of these depths."""
    spent, each = 0.0, max(1, steps // len(depths_m))
    for depth_m in depths_m:
        sim.rov.place((0.0, 0.0, -depth_m))
        spent += spent_s(lambda: sim.step(each))
    return spent / (each * len(depths_m))
