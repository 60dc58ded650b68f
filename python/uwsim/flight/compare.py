"""compare: fly several missions in the same scenario, each with several seeds, and compare the results."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from uwsim.base.atomic_file import write_atomically
from uwsim.flight.fly import fly
from uwsim.flight.folder import made_folder
from uwsim.flight.record import FlightRecord
from uwsim.flight.request import EstimateKind
from uwsim.flight.seen_bed import CELL_M, SeenBed
from uwsim.flight.summary import vehicle_values
from uwsim.missions.run import MissionFunction
from uwsim.scenario import Scenario
from uwsim.scoring.score_json import write_json
from uwsim.simulator.simulator import Simulator

TABLE, VALUES, FIGURE = "compare.csv", "compare.json", "compare.png"
Curve = tuple[list[float], list[float]]


@dataclass(frozen=True)
class Row:
    """The results of one flight.

    seen_m2: total area of the 1 m x 1 m columns in which the sonar has received an echo. seen_share: seen_m2 as a share
    of the area seen by all compared flights together. half_seen_s: time at which half of seen_m2 had been seen.
    effort_s: mean absolute command, integrated over time: equivalent seconds of full thrust. estimate_rms_m: RMS
    distance between true and estimated position; 0 if the mission uses the truth. map_coverage: coverage within
    scored_area_m. map_error_m: mean distance of the map's occupied voxels from the true surface. Both are NaN without a
    scored map.
    """

    mission: str
    seed: int
    ended_because: str
    time_s: float
    path_m: float
    effort_s: float
    battery_percent: float
    collisions: int
    estimate_rms_m: float
    seen_m2: float
    seen_share: float
    half_seen_s: float
    map_coverage: float
    map_error_m: float


@dataclass(frozen=True, eq=False)
class Comparison:
    """The results of all flights.

    rows: ordered by mission, then by seed. curves: for each mission, one curve per seed: times [s] and the area seen by
    then [m2].
    """

    rows: list[Row]
    curves: dict[str, list[Curve]]


def compare(
    missions: Mapping[str, MissionFunction | Path],
    scenario: str | Path | Scenario = "cove",
    out: str | Path = "compare",
    *,
    seeds: Iterable[int] = (0, 1, 2),
    arguments: Mapping[str, Any] | None = None,
    estimate: EstimateKind = "truth",
    faults: Sequence[Mapping[str, Any]] = (),
    time_limit_s: float | None = None,
    voxel_m: float | None = None,
    threads: int | None = None,
    show: Callable[[str], AbstractContextManager[object]] = lambda activity: nullcontext(),
) -> Comparison:
    """Fly each mission with each seed; write compare.csv, compare.json, compare.png and each flight's folder.

    missions: functions or files, keyed by their names in the table. arguments: passed to every mission. estimate:
    source of the poses that the missions use, "truth" or the vehicle's "filter". faults: injected into each flight,
    written as in a scenario's `faults`. show: returns a context manager that displays an activity. Raises ValueError if
    there is nothing to compare or a fault is invalid, OSError if `out` cannot be written, and any error that a mission
    raises.
    """
    numbers = list(seeds)
    if not missions or not numbers:
        raise ValueError("compare: needs at least one mission and one seed")
    if len(set(numbers)) < len(numbers):
        raise ValueError(f"seeds = {numbers}: must not contain duplicates")
    folder = made_folder(Path(out), (TABLE, VALUES, FIGURE))
    flown: list[tuple[str, int, FlightRecord, SeenBed]] = []
    for name, mission in missions.items():
        for seed in numbers:
            with show(f"flying {name}, seed {seed}"):
                sim = Simulator(scenario, seed=seed, threads=threads)
                for fault in faults:
                    sim.faults.inject(**fault)
                seen = SeenBed(sim, sim.vehicles)
                sim.journal.attach(seen)
                record = fly(
                    mission, sim, folder / f"{name}-{seed}", arguments=arguments, estimate=estimate, map=True,
                    voxel_m=voxel_m, time_limit_s=time_limit_s, report="json",
                )  # fmt: skip
                flown.append((name, seed, record, seen))
    everything = set().union(*(seen.cells for *_, seen in flown))
    rows = [_row(name, seed, record, seen, len(everything)) for name, seed, record, seen in flown]
    curves: dict[str, list[Curve]] = {name: [] for name in missions}
    for name, _, _, seen in flown:
        curves[name].append((seen.times_s, seen.areas_m2))
    found = Comparison(rows, curves)
    _write(found, folder, {"estimate": estimate, "faults": [dict(fault) for fault in faults]})
    return found


def _row(name: str, seed: int, record: FlightRecord, seen: SeenBed, all_cells: int) -> Row:
    samples = list(record.samples.values())
    periods_s = [np.diff(s["time_s"], append=s["time_s"][-1:]) for s in samples]
    area_m2 = len(seen.cells) * CELL_M**2
    half = int(np.searchsorted(seen.areas_m2, 0.5 * area_m2))
    return Row(
        mission=name,
        seed=seed,
        ended_because=record.ended_because,
        time_s=record.simulated_s,
        path_m=sum(float(np.linalg.norm(np.diff(s.path_world_m, axis=0), axis=1).sum()) for s in samples),
        effort_s=sum(float(np.abs(s.commands).mean(axis=1) @ dt) for s, dt in zip(samples, periods_s, strict=True)),
        battery_percent=sum(float(s["battery_percent"][0] - s["battery_percent"][-1]) for s in samples),
        collisions=record.collisions,
        estimate_rms_m=max(vehicle_values(s)["estimate_rms_m"] for s in samples),
        seen_m2=area_m2,
        seen_share=len(seen.cells) / all_cells if all_cells else float("nan"),
        half_seen_s=seen.times_s[half] if area_m2 else float("nan"),
        map_coverage=record.score.coverage if record.score is not None else float("nan"),
        map_error_m=record.score.distance_mean_m if record.score is not None else float("nan"),
    )


def _write(found: Comparison, folder: Path, flown_by: dict[str, Any]) -> None:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([field.name for field in fields(Row)])
    writer.writerows(asdict(row).values() for row in found.rows)
    write_atomically(folder / TABLE, text.getvalue().encode())
    curves = {name: [{"time_s": t, "seen_m2": a} for t, a in lines] for name, lines in found.curves.items()}
    rows = [{key: None if value != value else value for key, value in asdict(row).items()} for row in found.rows]
    write_json(folder / VALUES, {**flown_by, "rows": rows, "seen_over_time": curves})
    from uwsim.figures.comparison import draw_comparison  # imported here, since matplotlib takes a second

    draw_comparison(folder / FIGURE, found.curves)
