"""Measures how far an uncontrolled vehicle tilts under constant efforts in deep, still, fresh water."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.base.axes import AXES
from uwsim.base.quaternions import of_yaw_pitch_roll_deg
from uwsim.batch.batch import Batch
from uwsim.evidence.validate.flights import START_M, deep_scenario
from uwsim.scenario import VehicleModel, load_vehicle

EFFORTS = tuple(k / 10 for k in range(1, 11))
START_TILT_DEG = 2.0  # in roll and pitch, to start away from the vehicle leaves an unstable equilibrium
FLIGHT_S, SAMPLE_S = 60.0, 0.1


def largest_tilts_deg(model: VehicleModel, efforts: Sequence[float] = EFFORTS) -> Floats:
    """Return the largest angles (6, n) between body z and the vertical during a minute of each effort on each axis.

    Rows of axes on which the vehicle cannot be driven are NaN.
    """
    commands = np.concatenate([np.outer(efforts, axis) for axis in np.eye(6)])
    scenario = deep_scenario(model)
    batch = Batch(scenario, n=len(commands))
    batch.place(START_M, of_yaw_pitch_roll_deg((0.0, START_TILT_DEG, START_TILT_DEG)))
    lowest_cosine = np.ones(len(commands))
    for _ in range(round(FLIGHT_S / SAMPLE_S)):
        batch.step(round(SAMPLE_S / scenario.step_s), commands)
        x, y = batch.observe().orientation_xyzw.T[:2]
        lowest_cosine = np.minimum(lowest_cosine, 1.0 - 2.0 * (x * x + y * y))
    driven = batch.simulator(0).rov.controllable
    tilts = np.degrees(np.arccos(np.maximum(lowest_cosine, -1.0))).reshape(6, -1)
    tilts[[axis not in driven for axis in AXES]] = np.nan
    return tilts


def tilt_table(names: Sequence[str]) -> list[str]:
    """Return the rows of a Markdown table: vehicle, axis, and the largest tilt in degrees for each effort."""
    rows = [f"| vehicle | axis | {' | '.join(map(str, EFFORTS))} |", "|---|---|" + "---|" * len(EFFORTS)]
    for name in names:
        for axis, tilts in zip(AXES, largest_tilts_deg(load_vehicle(name)), strict=True):
            if not np.isnan(tilts).any():
                rows.append(f"| {name} | {axis} | {' | '.join(f'{tilt:.0f}' for tilt in tilts)} |")
    return rows
