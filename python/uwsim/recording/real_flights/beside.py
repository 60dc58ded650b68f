"""A model flown beside a log: it starts from the log's motion, gets its commands, and its error grows with the horizon.

Windows start evenly over the log. Of one horizon, only windows that do not overlap count, so that their errors may be
taken as independent; the interval of the mean is that of a bootstrap over them (Efron and Tibshirani 1993, An
Introduction to the Bootstrap, ch. 13).
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from uwsim.base.arrays import Floats
from uwsim.base.short_repr import ShortRepr
from uwsim.batch import Batch, arguments
from uwsim.recording.real_flights.deep_water import STEP_S, in_deep_water, start_m
from uwsim.recording.real_flights.motion import GAP_S, MotionLog, command
from uwsim.scenario import VehicleModel
from uwsim.scenario.build.hull import is_boat
from uwsim.scenario.build.vehicle import double_integrator
from uwsim.scenario.read.note import Note

HORIZONS_S = (1.0, 2.0, 5.0, 10.0, 30.0)
WINDOWS_MAX = 120
CHUNK = 2  # steps between changes of the commands
ROLL_S = 1.0  # before each window, so that thrusters turn as commanded when it begins
DIFFERENCE_S = 0.5  # over which positions are differentiated
DRAWS, LEVEL = 2000, 0.95
ERRORS = {"place": "m", "depth": "m", "heading": "deg", "tilt": "deg", "speed": "m/s"}
"""Errors of the model: horizontal distance, depth, heading, angle between the vertical axes, velocity."""
SIMPLEST = "double integrator"


@dataclass(frozen=True)
class Mean:
    """A mean over `count` windows, and the ends of its 95 % interval, which a single window does not have."""

    value: float
    low: float | None
    high: float | None
    count: int


@dataclass(frozen=True, eq=False, repr=False)
class Beside(ShortRepr):
    """Errors by horizon [s], then by ERRORS; moved: how far the vehicle itself went [m]. None: nothing was measured.

    integrator: as horizons, of the simplest model, see double_integrator(), in the same windows.
    """

    horizons: dict[float, dict[str, Mean | None]]
    integrator: dict[float, dict[str, Mean | None]]
    moved: dict[float, Mean | None]
    notes: tuple[Note, ...]

    def rows(self) -> list[tuple[str, ...]]:
        """Return a table: a heading, then for each horizon a row of the model, and one of the double integrator."""
        heads = [f"{name} [{unit}]" for name, unit in ERRORS.items()]
        rows: list[tuple[str, ...]] = [("horizon [s]", "windows", "moved [m]", *heads)]
        for horizon_s, errors in self.horizons.items():
            found = [self.moved[horizon_s], *(errors[name] for name in ERRORS)]
            count = max((each.count for each in found if each), default=0)
            rows.append((f"{horizon_s:g}", str(count), *(_shown(each) for each in found)))
            simplest = (_shown(self.integrator[horizon_s][name]) for name in ERRORS)
            rows.append((f"{horizon_s:g}, {SIMPLEST}", str(count), rows[-1][2], *simplest))
        return rows

    def plain(self) -> list[dict[str, object]]:
        """Return the table for JSON."""
        return [
            {
                "horizon_s": h,
                "moved_m": _values(self.moved[h]),
                **_named(errors),
                "double_integrator": _named(self.integrator[h]),
            }
            for h, errors in self.horizons.items()
        ]


def _named(errors: dict[str, Mean | None]) -> dict[str, dict[str, float | None] | None]:
    return {f"{name}_{unit.replace('/', '_')}": _values(errors[name]) for name, unit in ERRORS.items()}


def _shown(mean: Mean | None) -> str:
    if mean is None:
        return "-"
    return f"{mean.value:.3g} " + ("(one window)" if mean.low is None else f"({mean.low:.3g} to {mean.high:.3g})")


def _values(mean: Mean | None) -> dict[str, float | None] | None:
    return None if mean is None else {"mean": mean.value, "low": mean.low, "high": mean.high, "windows": mean.count}


def fly_beside(
    log: MotionLog,
    model: VehicleModel,
    *,
    density_kg_m3: float = 1000.0,
    horizons_s: Sequence[float] = HORIZONS_S,
    threads: int | None = None,
) -> Beside:
    """Fly a vehicle's model beside a log, in still water, see in_deep_water.

    Raises ValueError for a log shorter than a horizon.
    """
    span_s = float(log.times_s[-1] - log.times_s[0])
    wanted = [each for each in horizons_s if each + ROLL_S <= span_s]
    if not wanted:
        raise ValueError(f"log: {span_s:.3g} s of motion: must be at least {min(horizons_s) + ROLL_S:g} s")
    velocity, notes = _velocities(log)
    arguments.require_possible("log", log.times_s, velocity)
    state = np.hstack([log.position_m, log.orientation_xyzw, velocity])
    starts = _starts(log, min(wanted))
    measured = np.hstack([log.position_m, log.orientation_xyzw, log.velocity_body])
    horizons: dict[float, dict[str, Mean | None]] = {}
    integrator: dict[float, dict[str, Mean | None]] = {}
    simplest = double_integrator(model, density_kg_m3)
    moved: dict[float, Mean | None] = {}
    for h in wanted:
        rows = starts[_apart(log.times_s[starts], h) & (log.times_s[starts] + h <= log.times_s[-1])]
        if not len(rows):
            continue
        first, logged = state[rows], _at(log.times_s, measured, log.times_s[rows] + h)
        logged[:, :3] -= first[:, :3]
        for each, errors in ((model, horizons), (simplest, integrator)):
            flown = _flown(log, each, log.times_s[rows], first, density_kg_m3, round(h / STEP_S), threads)
            off = _errors(flown, logged) | ({"tilt": np.empty(0)} if log.unstated else {})
            errors[h] = {name: _mean(values) for name, values in off.items()}
        moved[h] = _mean(_length(logged[:, :3]))
    notes += [Note("missing", f"a horizon of {h:g} s: the log is too short") for h in horizons_s if h not in horizons]
    lacking = [name for name in ERRORS if all(errors[name] is None for errors in horizons.values())]
    notes += [Note("missing", f"the error of {name}: the log does not have what it needs") for name in lacking]
    where = "the calm surface" if is_boat(model, density_kg_m3) else "deep, still water"
    notes.append(Note("assumed", f"{where} of {density_kg_m3:g} kg/m3, without tether, current, waves and wind"))
    return Beside(horizons, integrator, moved, tuple(notes))


def _velocities(log: MotionLog) -> tuple[Floats, list[Note]]:
    """Return velocities (n, 6), in the body's axes: those measured, else from positions, else 0; and notes."""
    velocity, notes = log.velocity_body.copy(), []
    lacks = ~np.isfinite(velocity[:, :3])
    if lacks.any():
        low = np.searchsorted(log.times_s, log.times_s - 0.5 * DIFFERENCE_S)
        high = np.minimum(np.searchsorted(log.times_s, log.times_s + 0.5 * DIFFERENCE_S), len(log.times_s) - 1)
        span_s = np.maximum(log.times_s[high] - log.times_s[low], 1e-9)[:, None]
        world = np.where(span_s <= 2 * GAP_S, (log.position_m[high] - log.position_m[low]) / span_s, np.nan)
        if not np.isfinite(world).any():
            notes.append(Note("assumed", "each window begins at rest: the log has no velocity and no position"))
        elif not np.isfinite(world[:, :2]).any():
            way = "without horizontal velocity, which the log does not have; its vertical one is that of the depth"
            notes.append(Note("assumed", f"each window begins {way}"))
        else:
            notes.append(Note("assumed", "velocities where none is measured are differences of positions, else 0"))
        body = Rotation.from_quat(log.orientation_xyzw).inv().apply(np.nan_to_num(world))
        velocity[:, :3] = np.where(lacks, body, velocity[:, :3])
    if not np.isfinite(velocity[:, 3:]).all():
        notes.append(Note("assumed", "rates where none is measured are 0"))
    return np.nan_to_num(velocity), notes


def _starts(log: MotionLog, shortest_s: float) -> NDArray[np.intp]:
    """Return the rows at which windows begin, evenly spaced, after the commands are known for a while."""
    earliest = max(log.times_s[0], log.effort_times_s[0] + ROLL_S)
    last = log.times_s[-1] - shortest_s
    earliest = earliest if last > earliest else log.times_s[0]
    times_s = np.linspace(earliest, last, min(WINDOWS_MAX, max(int((last - earliest) / shortest_s) + 1, 1)))
    return np.unique(np.searchsorted(log.times_s, times_s))


def _apart(begin_s: Floats, horizon_s: float) -> NDArray[np.bool_]:
    """Return which windows to keep, so that none overlaps the one before."""
    kept, until = np.zeros(len(begin_s), bool), -np.inf
    for k, begin in enumerate(begin_s):
        if begin >= until - 1e-6:
            kept[k], until = True, begin + horizon_s
    return kept


def _flown(
    log: MotionLog,
    model: VehicleModel,
    begin_s: Floats,
    first: Floats,
    density_kg_m3: float,
    ticks: int,
    threads: int | None,
) -> Floats:
    """Return the states (windows, 13) after some steps, positions relative to the window's start."""
    with tempfile.TemporaryDirectory(prefix="uwsim-") as folder:
        alone = in_deep_water(model, density_kg_m3, Path(folder))
        batch, at_m = Batch(alone, n=len(begin_s), threads=threads), np.tile(start_m(alone), (len(begin_s), 1))
        for tick in range(-round(ROLL_S / STEP_S), ticks, CHUNK):
            if tick in (-round(ROLL_S / STEP_S), 0):
                batch.place(at_m, first[:, 3:7], first[:, 7:])
            index = np.searchsorted(log.effort_times_s, begin_s + (tick + 1e-3) * STEP_S, side="right") - 1
            command(batch, log.thrusters, np.where((index >= 0)[:, None], log.efforts[np.maximum(index, 0)], 0.0))
            batch.step(min(CHUNK, ticks - tick))
        motion = batch.observe()
    return np.hstack([motion.position_world_m - at_m, motion.orientation_xyzw, motion.velocity_body])


def _at(times_s: Floats, state: Floats, wanted_s: Floats) -> Floats:
    """Return logged states (m, 13) at some times; NaN outside the log and in gaps."""
    after = np.clip(np.searchsorted(times_s, wanted_s), 1, len(times_s) - 1)
    gap_s = times_s[after] - times_s[after - 1]
    share = ((wanted_s - times_s[after - 1]) / gap_s)[:, None]
    turn = Rotation.from_quat(state[after - 1, 3:7])
    other = Rotation.from_quat(state[after, 3:7])
    found: Floats = state[after - 1] + share * (state[after] - state[after - 1])
    found[:, 3:7] = (turn * Rotation.from_rotvec(share * (turn.inv() * other).as_rotvec())).as_quat()
    is_known = (gap_s <= GAP_S) & (share[:, 0] > -1e-6) & (share[:, 0] < 1 + 1e-6)
    found[~is_known] = np.nan
    return found


def _errors(flown: Floats, logged: Floats) -> dict[str, Floats]:
    known = np.isfinite(logged[:, 3:7]).all(axis=1)
    heading, tilt = np.full(len(flown), np.nan), np.full(len(flown), np.nan)
    if known.any():
        turn, other = Rotation.from_quat(flown[known, 3:7]), Rotation.from_quat(logged[known, 3:7])
        up, other_up = turn.inv().apply([0, 0, 1]), other.inv().apply([0, 0, 1])
        tilt[known] = np.degrees(np.arccos(np.clip((up * other_up).sum(axis=1), -1.0, 1.0)))
        ahead, other_ahead = turn.apply([1, 0, 0]), other.apply([1, 0, 0])
        off = np.arctan2(ahead[:, 1], ahead[:, 0]) - np.arctan2(other_ahead[:, 1], other_ahead[:, 0])
        heading[known] = np.abs(np.degrees((off + np.pi) % (2 * np.pi) - np.pi))
    return {
        "place": np.linalg.norm(flown[:, :2] - logged[:, :2], axis=1),
        "depth": np.abs(flown[:, 2] - logged[:, 2]),
        "heading": heading,
        "tilt": tilt,
        "speed": _length(flown[:, 7:10] - logged[:, 7:10]),
    }


def _length(way_m: Floats) -> Floats:
    """Return lengths (n,) of vectors (n, 3), of their known parts; NaN if none is."""
    return np.where(np.isfinite(way_m).any(axis=1), np.sqrt(np.nansum(way_m**2, axis=1)), np.nan)


def _mean(values: Floats) -> Mean | None:
    values = values[np.isfinite(values)]
    if len(values) < 2:
        return Mean(float(values[0]), None, None, 1) if len(values) else None
    draws = np.random.default_rng(0).choice(values, (DRAWS, len(values))).mean(axis=1)
    low, high = np.quantile(draws, [0.5 - 0.5 * LEVEL, 0.5 + 0.5 * LEVEL])
    return Mean(float(values.mean()), float(low), float(high), len(values))
