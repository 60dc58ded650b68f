"""Predictions with intervals, frozen before the data that judge them were opened: predictions.yaml.

Each function in COMPUTED returns a quantity as the simulator has it now; the file holds what it returned when it was
frozen. Nothing here writes the file.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import StringConstraints
from rich.console import Console
from rich.table import Table
from scipy.spatial.transform import Rotation

from uwsim.base.arrays import Floats
from uwsim.evidence.validate.camera import irradiance_variation
from uwsim.evidence.validate.flights import START_M, deep_water
from uwsim.evidence.validate.reality import predicted_trials as trials
from uwsim.evidence.validate.reality.arm_tilts import arm_at, flown_deg
from uwsim.evidence.validate.report import row_console
from uwsim.scenario import load_vehicle
from uwsim.scenario.read.spec_file import read_yaml
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.actuator import load_thruster
from uwsim.scenario.spec.fields import Model
from uwsim.simulator.simulator import Simulator

FILE = Path(__file__).with_name("predictions.yaml")
N_PER_KGF = 9.80665
FITTED_HULL_NM = (1.988, -0.448, 4.293)  # arm_tilts.fitted_hull_nm of all 26 trials
ARM_AHEAD_RAD = {"b": 2.879, "c": 3.0, "d": 1.6, "e": 3.07}
TLOG_PWM_US, NOMINAL_V = (1697.0, 1703.0, 1719.0, 1681.0), 16.0
RESULTS = {"hit": "hit", "MISS": "missed", "open": "open"}

Date = Annotated[str, StringConstraints(pattern=r"^\d{4}-\d\d-\d\d$")]


class Measured(Model):
    """A measured value, when and by whom it was read from its data."""

    value: float
    date: Date
    source: str


class Prediction(Model):
    """An entry of the file; see its head. measured: None until the data are opened."""

    quantity: str
    frozen: Date
    text: str
    unit: str
    value: float
    interval: tuple[float, float]
    basis: str
    judge: str
    measured: Measured | None

    @property
    def result(self) -> str:
        """`open` without a measured value, else `hit` or `MISS`."""
        if self.measured is None:
            return "open"
        low, high = self.interval
        return "hit" if low <= self.measured.value <= high else "MISS"


class _File(Model):
    predictions: list[Prediction]


def read_predictions(path: Path = FILE) -> list[Prediction]:
    """Return the entries in file order. Raises ScenarioError."""
    document = read_yaml(path, path.name)
    return validated(_File, document.values, document).predictions


def current_predictions(entries: list[Prediction]) -> dict[str, Prediction]:
    """Return the entry with the latest date of each quantity."""
    return {entry.quantity: entry for entry in sorted(entries, key=lambda entry: entry.frozen)}


def print_predictions(console: Console | None = None) -> None:
    """Print each prediction beside the simulator's value of today and the measured value, and the number of hits."""
    table = Table(title="predictions, frozen before their data were opened", title_justify="left")
    for column in ("frozen", "quantity", "predicted", "today", "measured", ""):
        table.add_column(column, overflow="fold")
    entries = read_predictions()
    for entry in entries:
        low, high = entry.interval
        measured = "" if entry.measured is None else f"{entry.measured.value:g} {entry.unit}"
        table.add_row(
            entry.frozen, entry.text, f"{low:g} to {high:g} {entry.unit}",
            f"{COMPUTED[entry.quantity]():.4g}", measured, entry.result,
        )  # fmt: skip
    target = console or row_console()
    target.print(table)
    results = [entry.result for entry in entries]
    target.print(", ".join(f"{results.count(result)} {text}" for result, text in RESULTS.items()))


def _t200(pwm_us: float, volts: float) -> tuple[float, float]:
    """Return thrust [kgf] and current [A]."""
    force_n, current_a, _ = load_thruster("t200_16v").performance().at((pwm_us - 1500.0) / 400.0, volts)
    return float(force_n) / N_PER_KGF, float(current_a)


def _neutral_bluerov2() -> Simulator:
    model = load_vehicle("bluerov2_wu")
    if model.mass_kg is None or model.volume_m3 is None:
        raise ValueError("bluerov2_wu: has neither mass nor volume")
    bare = model.model_copy(update={"sensors": {}, "sonar": None})
    return deep_water(bare, density_kg_m3=model.mass_kg / model.volume_m3)


def _sinking_m_s() -> float:
    sim = _neutral_bluerov2()
    sim.parameters["body.mass_kg"] += 1.0
    sim.advance(30.0)
    return -float(sim.rov.velocity.linear_body_m_s[2])


def _roll_period_s() -> float:
    sim, step_s = _neutral_bluerov2(), 0.02
    sim.rov.place(START_M, Rotation.from_euler("x", 15.0, degrees=True).as_quat())
    rolls = []
    for _ in range(300):
        sim.advance(step_s)
        rolls.append(float(np.arctan2(*sim.rov.pose.world_from_body[2, 1:3])))
    roll = np.array(rolls)
    before = np.flatnonzero(roll[:-1] * roll[1:] < 0)
    crossings_s = step_s * (before + roll[before] / (roll[before] - roll[before + 1]))
    return float(crossings_s[2] - crossings_s[0])


def _arm_ahead_deg() -> Floats:
    angles = {column: np.array([angle]) for column, angle in ARM_AHEAD_RAD.items()}
    flown: Floats = flown_deg(
        lambda times_s: arm_at({c: np.repeat(a, len(times_s)) for c, a in angles.items()}),
        np.array(FITTED_HULL_NM),
        np.array([0.0, 1.0]),
    )
    return np.asarray(flown[-1], np.float64)


def _irradiance_variation(depth_m: float) -> float:
    return 100.0 * float(irradiance_variation(depth_m)[2])


COMPUTED: dict[str, Callable[[], float]] = {
    "t200_ahead_18_v": lambda: _t200(1900.0, 18.0)[0],
    "t200_astern_18_v": lambda: _t200(1100.0, 18.0)[0],
    "t200_ahead_half_12_v": lambda: _t200(1700.0, 12.0)[0],
    "horizontal_thrusters_current": lambda: sum(_t200(pwm, NOMINAL_V)[1] for pwm in TLOG_PWM_US),
    "bluerov2_sinking": _sinking_m_s,
    "bluerov2_roll_period": _roll_period_s,
    "arm_ahead_pitch": lambda: float(_arm_ahead_deg()[0]),
    "arm_ahead_roll": lambda: float(_arm_ahead_deg()[1]),
    "slocum_battery_pitch": trials.battery_pitch_deg_mm,
    "slocum_third_glide": trials.glide_m_s,
    "remus100_turning_radius": lambda: trials.circle("remus100", 1.0).radius_m,
    "remus100_zigzag_overshoot": trials.zigzag_overshoot_deg,
    "bluerov2_yaw_rate": lambda: trials.yaw_step()[0],
    "bluerov2_yaw_rise": lambda: trials.yaw_step()[1],
    "otter_stopping": trials.stopping_m,
    "towed_rope_angle": trials.trailing_angle_deg,
    "em2040_swath": trials.swath_over_depth,
    "ping360_pipe_width": trials.pipe_width_deg,
    "t200_under_way": trials.thrust_share_under_way,
    "lauv_turning_radius": lambda: trials.circle("lauv", 1.0).radius_m,
    **{f"irradiance_variation_{z}_m": partial(_irradiance_variation, z) for z in (1, 5, 10, 20)},
}
