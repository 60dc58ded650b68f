"""compare: fly several missions in the same scenario, each with several seeds, and compare the results.

Each flight's folder holds its result, flight.json, so that `resume` flies only those that are missing; the table is
written after each flight.
"""

from __future__ import annotations

import csv
import hashlib
import inspect
import io
import json
import marshal
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from uwsim.base.atomic_file import write_atomically
from uwsim.base.own_files import remove_own_file
from uwsim.base.texts.json_text import json_value
from uwsim.flight.coverage import CELL_M, SeenBed
from uwsim.flight.fly import fly
from uwsim.flight.folder import made_folder
from uwsim.flight.paired import Pair, paired
from uwsim.flight.record import FlightRecord
from uwsim.flight.request import EstimateKind, file_digest
from uwsim.flight.samples import Samples
from uwsim.flight.summary import vehicle_values
from uwsim.missions.run import MissionFunction
from uwsim.scenario import AnyScenario, Scenario, load
from uwsim.scenario.fingerprint import build_fingerprint, scenario_fingerprint
from uwsim.scoring.score_text import write_json
from uwsim.simulator.simulator import Simulator

TABLE, VALUES, FIGURE = "compare.csv", "compare.json", "compare.png"
FLIGHT = "flight.json"  # in each flight's folder
Curve = tuple[list[float], list[float]]


@dataclass(frozen=True)
class Row:
    """The results of one flight.

    seen_m2: total area of the 1 m x 1 m columns in which the sonar has received an echo. seen_share: seen_m2 as a share
    of the area seen by all compared flights together. half_seen_s: time at which half of seen_m2 had been seen.
    effort_s: mean absolute command, integrated over time: equivalent seconds of full thrust. estimate_rms_m: RMS
    distance between true and estimated position; 0 if the mission uses the truth. map_coverage: coverage within
    scored_area_m. map_error_m: mean distance of the map's occupied voxels from the true surface. Both are NaN without a
    scored map. off_target_m: RMS distance of the first vehicle from a Target; NaN without one. ended_early: whether
    anything but the mission itself or the time limit ended the flight.
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
    off_target_m: float
    ended_early: bool = False


@dataclass(frozen=True)
class Target:
    """A place where a mission has to be at the end: world position (3,) [m], and for how long before the end [s]."""

    position_world_m: tuple[float, float, float]
    last_s: float


@dataclass(frozen=True, eq=False)
class Comparison:
    """The results of all flights.

    rows: ordered by mission, then by seed. curves: for each mission, one curve per seed: times [s] and the area seen by
    then [m2]. pairs: how the missions differ from the first one.
    """

    rows: list[Row]
    curves: dict[str, list[Curve]]
    pairs: list[Pair]


@dataclass(frozen=True, eq=False)
class _Flown:
    row: Row
    cells: frozenset[tuple[int, int]]
    curve: Curve


def compare(
    missions: Mapping[str, MissionFunction | Path | None],
    scenario: AnyScenario | Callable[[int], Scenario] = "cove",
    out: str | Path = "compare",
    *,
    seeds: Iterable[int] = (0, 1, 2),
    arguments: Mapping[str, Any] | None = None,
    estimate: EstimateKind = "truth",
    faults: Sequence[Mapping[str, Any]] = (),
    time_limit_s: float | None = None,
    voxel_m: float | None = None,
    target: Target | None = None,
    threads: int | None = None,
    resume: bool = False,
    show: Callable[[str], AbstractContextManager[object]] = lambda activity: nullcontext(),
    show_row: Callable[[Row], None] = lambda row: None,
) -> Comparison:
    """Fly each mission with each seed; write compare.csv, compare.json, compare.png and each flight's folder.

    missions: functions, files or None for the scenario's survey, keyed by their names in the table; all are compared
    with the first. scenario: may be a function of the seed. arguments: passed to every mission. estimate: source of the
    poses that the missions use, "truth" or the vehicle's "filter". faults: injected into each flight, written as in a
    scenario's `faults`. resume: keep the flights that `out` already holds. show: returns a context manager that
    displays an activity. show_row: called after each flight; its seen_share is that of the flights so far. Raises
    ValueError if there is nothing to compare, a fault is invalid, or a flight to keep was flown under other conditions;
    OSError if `out` cannot be written, and any error that a mission raises.
    """
    numbers = list(seeds)
    if not missions or not numbers:
        raise ValueError("compare: needs at least one mission and one seed")
    if len(set(numbers)) < len(numbers):
        raise ValueError(f"seeds = {numbers}: must not contain duplicates")
    folder = made_folder(Path(out), (TABLE, VALUES, FIGURE))
    scenario_of = scenario if callable(scenario) else lambda seed: load(scenario).with_changes(seed=seed)
    flown_by = {"estimate": estimate, "faults": [dict(fault) for fault in faults]}
    flown: dict[tuple[str, int], _Flown] = {}
    found = Comparison([], {}, [])
    for name, mission in missions.items():
        for seed in numbers:
            place, checked = folder / f"{name}-{seed}", scenario_of(seed)
            conditions = _digest(
                mission, scenario_fingerprint(checked), arguments, flown_by, time_limit_s, voxel_m, target
            )
            kept = _kept(place, conditions) if resume else None
            if kept is None:
                with show(f"flying {name}, seed {seed}"):
                    remove_own_file(place / FLIGHT)
                    sim = Simulator(checked, threads=threads)
                    for fault in faults:
                        sim.faults.inject(**fault)
                    seen = SeenBed(sim, sim.vehicles)
                    sim.journal.attach(seen)
                    record = fly(
                        mission, sim, place, arguments=arguments, estimate=estimate, map=True, voxel_m=voxel_m,
                        time_limit_s=time_limit_s, report="json",
                    )  # fmt: skip
                    row = _row(name, seed, record, seen, target)
                kept = _Flown(row, frozenset(seen.cells), (seen.times_s, seen.areas_m2))
                _keep(place, conditions, kept)
            flown[name, seed] = kept
            found = _compared(flown)
            _write(found, folder, flown_by)
            show_row(found.rows[-1])
    from uwsim.figures.comparison import draw_comparison  # imported here, since matplotlib takes a second

    draw_comparison(folder / FIGURE, found.curves)
    return found


def _digest(mission: MissionFunction | Path | None, *conditions: object) -> str:
    """Return a digest of everything that a flight depends on: its mission's source, its conditions, and this build."""
    what = [_source(mission), getattr(mission, "__qualname__", None), build_fingerprint()]
    return hashlib.blake2b(repr([*what, *conditions]).encode(), digest_size=16).hexdigest()


def _source(mission: MissionFunction | Path | None) -> str | None:
    """Return a digest of the mission's file or, in a notebook, its compiled code; None for the scenario's survey."""
    if mission is None or isinstance(mission, Path):
        return file_digest(mission) if mission is not None else None
    path = Path(inspect.getsourcefile(inspect.unwrap(mission)) or "")
    code = getattr(mission, "__code__", None)
    if path.is_file() or code is None:
        return file_digest(path) if path.is_file() else None
    return hashlib.blake2b(marshal.dumps(code, 2), digest_size=16).hexdigest()  # version 2: without references


def _keep(folder: Path, conditions: str, flown: _Flown) -> None:
    values = {"conditions": conditions, "row": asdict(flown.row), "cells": sorted(flown.cells), "curve": flown.curve}
    write_atomically(folder / FLIGHT, json.dumps(values).encode())


def _kept(folder: Path, conditions: str) -> _Flown | None:
    """Return an earlier flight; None if there is none. Raises ValueError if it was flown under other conditions."""
    path = folder / FLIGHT
    if not path.exists():
        return None
    try:
        values = json_value(path.read_bytes(), str(path))
        flown = _Flown(Row(**values["row"]), frozenset((i, j) for i, j in values["cells"]), tuple(values["curve"]))
        same = values["conditions"] == conditions
    except (KeyError, TypeError, ValueError):
        raise ValueError(f"--resume: '{path}': is damaged; remove it to fly again") from None
    if not same:
        raise ValueError(f"--resume: '{path}': mission, scenario, options or build have changed: choose another --out")
    return flown


def _compared(flown: Mapping[tuple[str, int], _Flown]) -> Comparison:
    everything = len(frozenset().union(*(each.cells for each in flown.values())))
    rows = [replace(each.row, seen_share=len(each.cells) / (everything or np.nan)) for each in flown.values()]
    curves: dict[str, list[Curve]] = {name: [] for name, _ in flown}
    for (name, _), each in flown.items():
        curves[name].append(each.curve)
    return Comparison(rows, curves, paired(rows))


def _row(name: str, seed: int, record: FlightRecord, seen: SeenBed, target: Target | None) -> Row:
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
        seen_share=float("nan"),
        half_seen_s=seen.times_s[half] if area_m2 else float("nan"),
        map_coverage=record.score.coverage if record.score is not None else float("nan"),
        map_error_m=record.score.distance_mean_m if record.score is not None else float("nan"),
        off_target_m=_off(samples[0], target) if target is not None else float("nan"),
        ended_early=record.ended_early,
    )


def _off(samples: Samples, target: Target) -> float:
    last = samples["time_s"] >= samples["time_s"][-1] - target.last_s
    off_m = np.linalg.norm(samples.path_world_m[last] - target.position_world_m, axis=1)
    return float(np.sqrt((off_m**2).mean()))


def _write(found: Comparison, folder: Path, flown_by: dict[str, Any]) -> None:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([field.name for field in fields(Row)])
    writer.writerows(asdict(row).values() for row in found.rows)
    write_atomically(folder / TABLE, text.getvalue().encode())
    curves = {name: [{"time_s": t, "seen_m2": a} for t, a in lines] for name, lines in found.curves.items()}
    rows, pairs = ([plain_row(each) for each in table] for table in (found.rows, found.pairs))
    write_json(folder / VALUES, {**flown_by, "rows": rows, "pairs": pairs, "seen_over_time": curves})


def plain_row(row: Row | Pair) -> dict[str, Any]:
    """Return a row's values for JSON, which has no NaN."""
    return {key: None if value != value else value for key, value in asdict(row).items()}
