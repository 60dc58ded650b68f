"""Flights whose navigation starts with drawn errors, and checks of the filter's errors against its covariance.

Consistency: the normalised estimation error squared, NEES = e^T P^-1 e, of N independent flights at one time has mean n
(here n = 9: position, velocity, attitude), and N times its average is chi-square distributed with N n degrees of
freedom (Bar-Shalom, Li and Kirubarajan 2001, "Estimation with Applications to Tracking and Navigation", ch. 5.4).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from uwsim.base.arrays import Floats
from uwsim.evidence.validate.check import Check, Curve, within
from uwsim.navigation.estimation import Navigator, Start
from uwsim.simulator.onboard_navigation import new_navigator
from uwsim.simulator.simulator import Simulator

LEG_S = 3.0
ERRORS = 9
PARTS = {"position": slice(0, 3), "velocity": slice(3, 6), "attitude": slice(6, 9)}
START_WORLD_M = (-30.0, -40.0, -12.0)
POSITION_STD_M, VELOCITY_STD_M_S = 0.5, 0.05
LARGEST_EFFORTS = np.array([0.5, 0.4, 0.1, 0.05, 0.05, 0.5])


def start_navigation(
    sim: Simulator,
    seed: int,
    start_world_m: tuple[float, float, float] = START_WORLD_M,
    velocity_m_s: tuple[float, float, float] = (0.0, 0.0, 0.0),
    *,
    position_std_m: float = POSITION_STD_M,
    velocity_std_m_s: float = VELOCITY_STD_M_S,
) -> tuple[Navigator, np.random.Generator]:
    """Begin a flight heading east, with navigation errors drawn from the initial covariance."""
    sim.reset(seed=seed)
    sim.rov.place(start_world_m, velocity_body=np.array([*velocity_m_s, 0.0, 0.0, 0.0]))
    draws = np.random.default_rng(seed)
    position = np.asarray(start_world_m) + position_std_m * draws.standard_normal(3)
    velocity = np.asarray(velocity_m_s) + velocity_std_m_s * draws.standard_normal(3)
    start = Start(tuple(position.tolist()), position_std_m, tuple(velocity.tolist()), velocity_std_m_s)
    return new_navigator(sim.rov, start, sim.world.water), draws


def errors(sim: Simulator, navigator: Navigator) -> Floats:
    """Return the errors (9,): position and velocity in world axes, attitude in body axes."""
    pose, true = navigator.pose, sim.rov.pose
    turn, true_turn = pose.world_from_body[:3, :3], true.world_from_body[:3, :3]
    velocity = true_turn @ sim.rov.velocity.linear_body_m_s - turn @ navigator.velocity.linear_body_m_s
    attitude = Rotation.from_matrix(turn.T @ true_turn).as_rotvec()
    return np.concatenate([true.position_world_m - pose.position_world_m, velocity, attitude])


def nees_of(error: Floats, covariance: Floats, part: slice) -> float:
    """Return the normalised estimation error squared for a part of the errors."""
    return float(error[part] @ np.linalg.solve(covariance[part, part], error[part]))


def consistency_checks(nees: Floats, how: str = "", looks_s: float = 1.0) -> list[Check]:
    """Return the checks on NEES values, (flights, times, 1 + PARTS), and on their means over all times.

    how: a description of the flights. looks_s: the time between looks. Errors are correlated within a flight, so the
    bounds of the means are those of a single time.
    """
    flights, looks = nees.shape[:2]
    group, mean = _group(flights, how), nees[:, :, 0].mean(axis=0)
    low, high = chi2.ppf([0.025, 0.975], flights * ERRORS) / flights
    inside = float(np.mean((mean > low) & (mean < high)))
    share = within(group, f"share of {looks} times within the 95 % bounds", 1.0, inside, 1.0, 0.25)
    levels = {"expected": float(ERRORS), "2.5 %": low, "97.5 %": high}
    lines = {name: np.full(looks, level) for name, level in levels.items()} | {"mean of flights": mean}
    share = replace(share, curve=Curve(looks_s * np.arange(1, looks + 1), lines, title=f"{group}: of 9 errors"))
    means = nees.mean(axis=0).mean(axis=0).tolist()
    checks = [share, within(group, "mean of all 9 errors", ERRORS, means[0], ERRORS, high / ERRORS - 1.0)]
    most = float(chi2.ppf(0.975, flights * 3) / flights / 3.0 - 1.0)
    return checks + [
        within(group, f"mean of {name}", 3.0, got, 3.0, most) for name, got in zip(PARTS, means[1:], strict=True)
    ]


def _group(flights: int, how: str) -> str:
    return f"NEES of {flights} {how} flights" if how else f"NEES of {flights} flights"
