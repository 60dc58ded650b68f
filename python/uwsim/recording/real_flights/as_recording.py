"""A log as a live recording: a scenario's first vehicle is placed along it, so that what reads recordings shows it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from uwsim.base.arrays import Floats
from uwsim.recording.real_flights.flight_log import FlightLog
from uwsim.recording.real_flights.motion import GAP_S, at_times
from uwsim.recording.recorder import Recorder
from uwsim.recording.timeline import FROM_LOG, LONGEST_S, SAMPLE_S
from uwsim.scenario.georeference import georeference
from uwsim.scenario.read.note import Note
from uwsim.simulator.simulator import Simulator


def record_log(log: FlightLog, sim: Simulator, path: Path) -> list[Note]:
    """Write a new recording, .mcap, and return notes on what was assumed or is missing.

    The command `place` is issued every SAMPLE_S, with the log's pose and velocity at that time; in between, the
    vehicle moves by the scenario's physics, its thrusters at rest. Raises OSError, or ValueError for a log without
    attitude or of more than 12 hours, or if the scenario has room for none of its poses. Where it has room for others
    only, the vehicle stays at the last of these.
    """
    if path.suffix != ".mcap":
        raise ValueError(f"--as-recording {path}: must end in .mcap")
    ticks, times_s, turns, is_turned = _attitudes(log, sim.step_s)
    start_m, scenario = sim.rov.pose.position_world_m, f"scenario '{sim.scenario.name}'"
    position, notes = _positions(log, sim, times_s)
    known = np.isfinite(position) & is_turned[:, None]
    notes += _held("attitude", is_turned)
    for name, axis in (("horizontal position", 0), ("depth", 2)):
        if not known[:, axis].any():
            notes.append(Note("missing", f"{name}: the vehicle keeps that of the start of {scenario}"))
        elif is_turned.any():
            notes += _held(name, known[:, axis])
    position = np.column_stack([_filled(position[:, k], known[:, k], start_m[k]) for k in range(3)])
    velocity = _velocities(log, times_s, position, turns, known)
    notes.append(Note("assumed", f"the vehicle is '{sim.rov.name}' of {scenario}; thrusters are at rest"))

    def place(k: int) -> None:
        sim.rov.place(position[k], turns[k].as_quat(), velocity[k])

    begin, has_room, why = sim.save_state(), np.ones(len(ticks), np.bool_), ""
    for k in range(len(ticks)):  # before a long run
        try:
            place(k)
        except ValueError as error:
            has_room[k] = False
            why = why or f"the first at {times_s[k]:.1f} s, in '{sim.scenario.name}': {error}"
    sim.restore_state(begin)
    if not has_room.any():
        raise ValueError(f"{log.path}: none of {len(ticks)} poses is possible: {why}")
    if left_out := int((~has_room).sum()):
        why = f"{left_out} of {len(ticks)} poses, {why}"
        notes.append(Note("left out", f"{why}; the vehicle stays where it was before"))
        position = np.column_stack([_filled(position[:, k], has_room, start_m[k]) for k in range(3)])
        velocity[~has_room] = 0.0
    place(0)
    first = sim.tick
    with Recorder(sim, path, is_light=True, notes={FROM_LOG: {"file": log.path.name, "notes": list(map(str, notes))}}):
        for k, tick in enumerate(ticks.tolist()[1:], 1):
            sim.step(first + tick - sim.tick)
            place(k)
        sim.step(1)
    return notes


def _attitudes(log: FlightLog, step_s: float) -> tuple[NDArray[np.int64], Floats, Rotation, NDArray[np.bool_]]:
    """Return ticks and times of samples, attitudes, and whether each is known: in gaps, the one before is kept.

    Samples are a step before those of a time line, which precede the commands of their tick.
    """
    if "attitude" not in log.series:
        raise ValueError(f"{log.path}: has no attitude: only a log that has it can be seen as a recording")
    series = log.series["attitude"]
    kept = np.linalg.norm(series.values, axis=1) > 0.5  # also false for NaN
    own_s, values = series.times_s[kept], series.values[kept]
    if len(own_s) < 2 or not own_s[-1] - own_s[0] <= LONGEST_S:
        span_s = np.ptp(own_s) if len(own_s) else 0.0
        raise ValueError(f"{log.path}: attitudes over {span_s:g} s: must be two or more, over at most {LONGEST_S:g} s")
    apart = max(round(SAMPLE_S / step_s), 1)
    ticks = np.arange(0, int((own_s[-1] - own_s[0]) / step_s) + 1, apart)
    ticks[1:] -= 1
    times_s = own_s[0] + step_s * ticks
    after = np.clip(np.searchsorted(own_s, times_s, side="right"), 1, len(own_s) - 1)
    is_known = own_s[after] - own_s[after - 1] <= GAP_S
    turns = Slerp(own_s, Rotation.from_quat(values))(np.where(is_known, times_s, own_s[after - 1]))
    return ticks, times_s, turns, is_known


def _positions(log: FlightLog, sim: Simulator, times_s: Floats) -> tuple[Floats, list[Note]]:
    """Return positions (n, 3) in the world, NaN where unknown, and notes."""
    logged = at_times(log.series.get("position"), times_s, 3)
    depth = at_times(log.series.get("depth"), times_s, 1)[:, 0]
    height = np.where(np.isfinite(depth), -depth, logged[:, 2])
    notes = []
    if not np.isfinite(depth).any() and np.isfinite(height).any():
        notes.append(Note("assumed", "the log's position is 0 m high at the surface: it has no depth"))
    place = georeference(sim.scenario)
    degrees = at_times(log.series.get("place"), times_s, 2)
    known = np.isfinite(degrees).all(axis=1)
    if place.crs is not None and known.any():
        logged[:, :2] = np.nan
        logged[known, :2] = [place.world_m(lat, lon, 0.0)[:2] for lat, lon in degrees[known].tolist()]
        notes.append(Note("known", "horizontal position from places on Earth"))
        return np.column_stack([logged[:, :2], height]), notes
    known = np.isfinite(logged[:, :2]).all(axis=1)
    logged[~known, :2] = np.nan
    if known.any():
        logged[:, :2] += sim.rov.pose.position_world_m[:2] - logged[known][0, :2]
        notes.append(Note("assumed", "the log's first position is that of the scenario's start; x is east, y north"))
    return np.column_stack([logged[:, :2], height]), notes


def _velocities(log: FlightLog, times_s: Floats, position: Floats, turns: Rotation, known: NDArray[np.bool_]) -> Floats:
    """Return velocities (n, 6) in the body's axes: those logged, else the way to the next sample, 0 beside gaps."""
    way, turn = np.zeros((len(times_s), 3)), np.zeros((len(times_s), 3))
    apart_s = np.diff(times_s)[:, None]
    way[:-1] = np.where(known[:-1] & known[1:], np.diff(position, axis=0) / apart_s, 0.0)
    turn[:-1] = (turns[:-1].inv() * turns[1:]).as_rotvec() / apart_s
    body = at_times(log.series.get("body velocity"), times_s, 3)
    if "velocity" in log.series and "body velocity" not in log.series:
        body = turns.inv().apply(at_times(log.series["velocity"], times_s, 3))
    body[~known[:, :2].all(axis=1)] = np.nan  # a vehicle that is kept in place does not move
    logged, found = np.hstack([body, at_times(log.series.get("rates"), times_s, 3)]), np.hstack([way, turn])
    found[:, :3] = turns.inv().apply(way)
    return np.where(np.isfinite(logged), logged, found)


def _filled(values: Floats, known: NDArray[np.bool_], default: float) -> Floats:
    """Return values with each unknown one replaced by the last known, at first by the first; a default if none is."""
    if not known.any():
        return np.full(len(values), default)
    last = np.maximum.accumulate(np.where(known, np.arange(len(values)), -1))
    return values[np.where(last < 0, np.argmax(known), last)]


def _held(name: str, known: NDArray[np.bool_]) -> list[Note]:
    stays = f"{name} stays as it was in {(~known).sum()} of {len(known)} samples, which lack it"
    return [] if known.all() else [Note("assumed", stays)]
