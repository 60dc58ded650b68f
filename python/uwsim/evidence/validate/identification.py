"""The identification suite: coefficients from logs whose commands lie between their rows, with their 95 % intervals.

The true coefficients are drawn from their priors, and the vehicle is simulated in deep water with random efforts. In
half of the logs the commands have their own times, late by an unknown delay; the others are tables, in which a command
is only seen in the next row.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from uwsim.base.arrays import Floats
from uwsim.batch import Batch
from uwsim.evidence.identification import Identified, MotionLog, identify
from uwsim.evidence.identification.unknowns import DELAY, parameters_at, unknowns
from uwsim.evidence.validate.check import Check, within
from uwsim.evidence.validate.flights import START_M, deep_scenario
from uwsim.recording.real_flights.deep_water import STEP_S
from uwsim.recording.real_flights.motion import sampled
from uwsim.scenario import VehicleModel, load_vehicle

GROUP = "identification"
LOGS = 4  # each takes about 10 s of processor time; `coverage(20)` is the trial that docs/guides/identify.md reports
DURATION_S, ROW_STEPS = 10.0, 20
NOISE = np.repeat((0.02, 0.005, 0.01, 0.005), 3)  # of position [m], attitude [rad], velocity [m/s], rate [rad/s]
EFFORTS = np.array([0.6, 0.6, 0.6, 0.1, 0.1, 0.4])
MOST_DELAY = 20  # steps
COVERED = (0.90, 0.98)
SLACK_OF_SIX = 0.28  # fewer than four of the six intervals cover by chance once in 400 trials
SLACK = 0.06  # four logs determine the share of intervals to about this: the errors within one log are correlated


@dataclass(frozen=True)
class TrueLog:
    """A simulated log and the values that it was simulated with."""

    log: MotionLog
    values: dict[str, float]


def run() -> list[Check]:
    """Return the checks of the suite."""
    share, lag = coverage(LOGS)
    middle, half = float(np.mean(COVERED)), 0.5 * (COVERED[1] - COVERED[0])
    return [
        within(GROUP, f"{LOGS} logs, commands between rows: share in 95 % intervals", middle, share, 1.0, half + SLACK),
        within(GROUP, "their thrust lag and delay: share in 95 % intervals", middle, lag, 1.0, SLACK_OF_SIX),
    ]


def coverage(logs: int, first_seed: int = 0, *, is_stated: bool = True) -> tuple[float, float]:
    """Return the shares of 95 % intervals that contain the truth: of all, and of thrust lag and delay.

    is_stated: whether the vehicle's file states its volume and centre of buoyancy.
    """
    model = load_vehicle("bluerov2_wu")
    given = model if is_stated else model.model_copy(update={"volume_m3": None, "centre_of_buoyancy_m": None})
    each_log = map(true_log, range(first_seed, first_seed + logs))
    inside = [covered(identify(true.log, given), true.values) for true in each_log]
    times = [each[name] for each in inside for name in ("thrust_lag", DELAY) if name in each]
    return float(np.mean([value for each in inside for value in each.values()])), float(np.mean(times))


def covered(found: Identified, truth: dict[str, float]) -> dict[str, bool]:
    """Return whether each interval contains the true value, by quantity."""
    values = found.values
    return {name: values[name].low <= value <= values[name].high for name, value in truth.items() if name in values}


def true_log(seed: int, model: VehicleModel | None = None, *, duration_s: float = DURATION_S) -> TrueLog:
    """Simulate a log: a table for odd seeds; for even ones, commands at times that are wrong by a delay."""
    model = load_vehicle("bluerov2_wu") if model is None else model
    draw = np.random.default_rng(seed)
    found = unknowns(model, "body", known=(DELAY,))
    z = draw.standard_normal(len(found))
    truth = {unknown.name: unknown.at(float(value)) for unknown, value in zip(found, z, strict=True)}
    truth |= {} if model.volume_m3 is None else {"volume_m3": model.volume_m3}
    bare = model.model_copy(update={"sensors": {}, "sonar": None})
    batch = Batch(deep_scenario(bare, step_s=STEP_S), n=1, parameters=parameters_at(found, z))
    batch.place([START_M])
    ticks = np.concatenate([[0], np.cumsum(draw.integers(200, 400, round(duration_s)))])
    efforts = draw.uniform(-1, 1, (len(ticks), 6)) * EFFORTS
    rows = _rows(batch, ticks, efforts, round(duration_s / STEP_S))
    noise = draw.standard_normal((len(rows), 12)) * NOISE
    turned = (Rotation.from_quat(rows[:, 3:7]) * Rotation.from_rotvec(noise[:, 3:6])).as_quat()
    times_s = np.asarray(STEP_S * ROW_STEPS * np.arange(len(rows)), np.float64)
    if seed % 2:
        last = np.searchsorted(ticks * STEP_S, times_s + 1e-9, side="right") - 1
        commands = sampled(times_s, efforts[last])
    else:
        truth[DELAY] = STEP_S * int(draw.integers(-MOST_DELAY, MOST_DELAY))
        commands = ticks * STEP_S - truth[DELAY], efforts, np.zeros(len(ticks))
    position_m, velocity = rows[:, :3] + noise[:, :3], rows[:, 7:] + noise[:, 6:]
    return TrueLog(MotionLog(times_s, position_m, turned, velocity, *commands[:2], {}, commands[2]), truth)


def _rows(batch: Batch, ticks: NDArray[np.int64], efforts: Floats, steps: int) -> Floats:
    """Return the states (n, 13), one every ROW_STEPS steps, with the efforts that begin at these ticks."""
    begins = dict(zip(ticks.tolist(), efforts, strict=True))
    held, rows = np.zeros(6), []
    stops = sorted({*range(0, steps + 1, ROW_STEPS), *(tick for tick in begins if tick < steps)})
    for tick, after in zip(stops, [*stops[1:], steps], strict=True):
        held = begins.get(tick, held)
        if tick % ROW_STEPS == 0:
            motion = batch.observe()
            rows.append(np.hstack([motion.position_world_m[0], motion.orientation_xyzw[0], motion.velocity_body[0]]))
        batch.step(after - tick, held[None])
    return np.array(rows)
