"""The estimation suite: the filter's errors compared with its covariance, and its drift without DVL or USBL.

Drift at constant attitude from a covariance P (Groves 2013, ch. 5.7, without the earth's rotation): the position error
is e_p + e_v t - R [f]x (e_attitude t^2 / 2 - e_rate t^3 / 6) - R e_force t^2 / 2, plus the integrals of white noise.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.stats import chi2

from uwsim.base.arrays import Floats
from uwsim.evidence.validate.check import Check, Curve, relative, within
from uwsim.evidence.validate.navigator.after_contact import contact_checks
from uwsim.evidence.validate.navigator.consistency import (
    ERRORS,
    LARGEST_EFFORTS,
    LEG_S,
    PARTS,
    consistency_checks,
    errors,
    nees_of,
    start_navigation,
)
from uwsim.evidence.validate.navigator.turning_flights import turning_checks
from uwsim.navigation.estimation import Navigator
from uwsim.simulator.simulator import Simulator

SEEDS = 50
LEGS, LEGS_PER_LOOK = 36, 3
DROP_OUT_AFTER_S, DROP_OUT_S = 60.0, 60.0


def run(seeds: int | None = None) -> list[Check]:
    """Return the checks of the suite. seeds: number of flights; by default SEEDS."""
    sim, seeds = Simulator("lake"), seeds or SEEDS
    nees = np.array([list(nees_of_a_flight(sim, seed)) for seed in range(seeds)])
    drifts = [drop_out(sim, seed) for seed in range(seeds)]
    return [
        *consistency_checks(nees, looks_s=LEG_S * LEGS_PER_LOOK),
        *turning_checks(seeds),
        *drop_out_checks(drifts),
        *contact_checks(sim, seeds),
    ]


def nees_of_a_flight(sim: Simulator, seed: int) -> Iterator[list[float]]:
    """Fly with random efforts; at intervals, yield the NEES of all errors and of each of PARTS."""
    navigator, draws = start_navigation(sim, seed)
    for leg in range(LEGS):
        sim.rov.set_effort(*(LARGEST_EFFORTS * draws.uniform(-1.0, 1.0, 6)))
        sim.advance(LEG_S)
        if leg % LEGS_PER_LOOK == LEGS_PER_LOOK - 1:
            error, covariance = errors(sim, navigator), navigator.covariance
            yield [nees_of(error, covariance, part) for part in (slice(0, ERRORS), *PARTS.values())]


def drop_out(sim: Simulator, seed: int) -> tuple[Floats, Floats, Floats]:
    """Hover, then switch off the DVL and USBL.

    Returns the final covariance of the horizontal position, from the filter and from the closed form, and the position
    error (2,).
    """
    navigator, draws = start_navigation(sim, seed)
    for _ in range(round(DROP_OUT_AFTER_S / LEG_S) - 3):
        sim.rov.set_effort(*(LARGEST_EFFORTS * draws.uniform(-1.0, 1.0, 6)))
        sim.advance(LEG_S)
    sim.rov.set_effort()
    sim.advance(3 * LEG_S)
    expected = closed_form(sim, navigator, DROP_OUT_S)
    sim.parameters.update({"rov.sensors.dvl.on": False, "rov.sensors.usbl.on": False})
    sim.advance(DROP_OUT_S)
    return navigator.covariance[:2, :2], expected, errors(sim, navigator)[:2]


def closed_form(sim: Simulator, navigator: Navigator, t: float) -> Floats:
    """Return the covariance (2, 2) of the horizontal position after t s with only the IMU, at constant attitude."""
    turn, gravity = navigator.pose.world_from_body[:3, :3], sim.world.water.gravity_m_s2
    imu = sim.rov.sensors["imu"].spec.noise
    force = turn @ _cross(turn.T @ [0.0, 0.0, gravity])
    eye = np.eye(3)
    growth = np.hstack([eye, t * eye, -0.5 * t**2 * force, t**3 / 6.0 * force, -0.5 * t**2 * turn])[:2]
    rate, accel = imu["angular_velocity"], imu["linear_acceleration"]
    variance = accel.density**2 * t**3 / 3.0 + gravity**2 * rate.density**2 * t**5 / 20.0
    # The drift is treated as a random walk of the bias with 2 std^2 / time.
    variance += 2.0 * accel.bias_std**2 / accel.bias_time_s * t**5 / 20.0
    variance += gravity**2 * 2.0 * rate.bias_std**2 / rate.bias_time_s * t**7 / 252.0
    return np.asarray(growth @ navigator.covariance @ growth.T + variance * np.eye(2))


def _cross(v: Floats) -> Floats:
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def drop_out_checks(drifts: list[tuple[Floats, Floats, Floats]]) -> list[Check]:
    """Return the checks on the drift."""
    group = f"{DROP_OUT_S:.0f} s without DVL and USBL"
    filters, closed, error = (np.array(part) for part in zip(*drifts, strict=True))
    expected, got = (np.sqrt(np.trace(c, axis1=1, axis2=2).mean()) for c in (closed, filters))
    nees = [float(e @ np.linalg.solve(p, e)) for e, p in zip(error, filters, strict=True)]
    band = chi2.ppf([0.025, 0.975], 2 * len(error)) / len(error) / 2.0
    growth = relative(group, "growth that the filter expects", float(expected), float(got), 0.1, "m")
    reach_m = np.sort(np.linalg.norm(error, axis=1))
    stds_m = {"closed form": expected / np.sqrt(2.0), "as the filter expects": got / np.sqrt(2.0)}
    lines = {name: chi2.cdf((reach_m / std_m) ** 2, 2) for name, std_m in stds_m.items()}
    flown = {"flights": np.linspace(0.0, 1.0, len(reach_m))}
    curve = Curve(reach_m, {**lines, **flown}, "horizontal error [m]", title=f"share of flights, {group}")
    return [
        replace(growth, curve=curve),
        within(group, "NEES of the horizontal position", 2.0, float(np.mean(nees)), 2.0, float(max(abs(band - 1.0)))),
    ]
