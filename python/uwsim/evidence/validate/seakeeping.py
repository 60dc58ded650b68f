"""The suite `seakeeping`: floating hulls that make and deflect waves, compared with Capytaine and with closed forms.

Capytaine 3.0.0 (Ancellin and Dias 2019, J. Open Source Software 4:1341) computed the tables of three hulls;
tests/python/data/make_capytaine_seakeeping.py makes them. Each hull has Capytaine's own table, which judges the
equations of motion, and not the table. It floats freely, without drag, in waves of 1 or 2 mm, so that linear theory
applies: its response per wave amplitude (RAO) is the solution of (-omega^2 (M + A) - i omega B + C) xi = X (Newman
1977, "Marine Hydrodynamics", sec. 6.17). A decay is compared with the inverse Laplace transform of Cummins' equation.
Haskind's relation gives the damping from the exciting force (Newman 1962, J. Ship Research 6(3):10): B = k |X|^2 / (4
rho g c_g) in heave of a body of revolution, with the group velocity c_g = g / (2 omega).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.evidence.validate.check import Check, along, at_most, relative, within
from uwsim.evidence.validate.peers.floating_hulls import (
    DENSITY_KG_M3,
    GRAVITY_M_S2,
    HULLS,
    FloatingHull,
    floating_hull,
    responses,
)

Array = NDArray[np.float64]

HEAVE, PITCH = 2, 4
RAO, CLOSED, HASKIND, SPECTRUM, PERIOD = 0.05, 0.01, 0.02, 0.03, 0.02
"""Tolerances."""
STEP_S = 0.01
CALM_M = 0.001
"""Amplitude of regular waves and of decays."""
SEA = {"significant_height_m": 0.002, "peak_period_s": 2.2, "heading_rad": 0.0, "seed": 3}
"""So small that the hulls, which have no drag, do not drift as fast as to meet the waves at other frequencies."""
SEA_S = 600.0
START_M_S, SPEED_M_S = 0.3, 0.268
"""Speeds of the barge into the waves: as released, and as the water that it sets in motion leaves it."""
AT_SPEED = {2.5: (1.064, 1.063), 3.5: (1.493, 3.257), 4.2: (0.627, 0.663)}
"""Capytaine's heave over amplitude and pitch over slope at SPEED_M_S, by frequency; make_capytaine_seakeeping.py."""
HEAVE_AT_SPEED, PITCH_AT_SPEED = 0.07, 0.25
"""Tolerances: an approximation, see docs/inside/water.md."""

DRIFT = {
    "barge": {2.5: 1.4, 3.5: 166.0, 4.8: 3519.0, 6.5: 3792.0, 8.5: 3745.0},
    "hemisphere": {4.827: 4438.0, 6.512: 3198.0},
}
"""Capytaine's mean drift of free hulls, by frequency, N per squared metre; make_capytaine_seakeeping.py."""
DRIFT_ERROR = 0.05
"""Tolerance, as a share of a wall's force as wide as the hull, rho g / 2 per metre of width and squared amplitude."""
WIDTH_M = {"barge": 0.8, "hemisphere": 1.0}


class Record(NamedTuple):
    """A hull's motion: times (n,), heave (n,) [m], pitch (n,), positive bow down [rad], x (n,) [m]."""

    time_s: Array
    heave_m: Array
    pitch_rad: Array
    x_m: Array


def run(out: Path | None = None) -> list[Check]:
    """Return the checks. It draws nothing."""
    return [*_raos(HULLS), *_forward_speed(), *_drift(), *_decays(), *_haskind(), *_energy(), *_irregular()]


def simulation(
    hull: FloatingHull, waves: _core.Waves | None, heave_m: float = 0.0, held: bool = False
) -> _core.Simulation:
    """Return a simulation of a hull without drag in deep water, at rest and upright."""
    world = _core.World()
    world.set_terrain(np.full((2, 2), -200.0, np.float32), 1000.0, (-500.0, -500.0))
    water = _core.Water()
    water.density_kg_m3, water.gravity_m_s2, water.waves = DENSITY_KG_M3, GRAVITY_M_S2, waves
    world.water = water
    spec = _core.SimulationSpec()
    spec.step_s = STEP_S
    made = _core.Simulation(world, _core.RayScene(world), spec)
    vehicle = _core.VehicleSpec()
    vehicle.name, vehicle.craft, vehicle.docked = hull.name, hull.craft, held
    vehicle.set_start((0.0, 0.0, -hull.waterline_m + heave_m), (0.0, 0.0, 0.0, 1.0))
    made.add_vehicle(vehicle)
    return made


def recorded(made: _core.Simulation, steps: int) -> Record:
    """Step and return the motion after each step."""
    rows = np.empty((steps, 4))
    start_z_m = float(made.state(0).position_world_m[2])
    for row in rows:
        made.step(1)
        state = made.state(0)
        x, y, z, w = state.orientation_xyzw
        row[:] = (
            1e-9 * made.time_ns,
            state.position_world_m[2] - start_z_m,
            math.asin(2.0 * (w * y - x * z)),
            state.position_world_m[0],
        )
    return Record(*rows.T)


def _raos(names: tuple[str, ...]) -> Iterator[Check]:
    for name in names:
        hull = floating_hull(name)
        for omega in hull.tried_rad_s:
            number = omega**2 / GRAVITY_M_S2
            motion = recorded(simulation(hull, _wave(omega)), round(hull.settling_s / STEP_S))
            expected = np.abs(responses(hull, np.array([omega]))[0])
            tried = (("heave", HEAVE, motion.heave_m, 1.0), ("pitch", PITCH, motion.pitch_rad, number))
            for label, axis, values, unit in tried:
                wanted = expected[axis]
                got = _amplitude(motion, values, omega, number) / (CALM_M * unit)
                scale = max(wanted / unit, hull.least_response)
                yield within("Capytaine", f"{name}, {label} at {omega:.3g} rad/s", wanted / unit, got, scale, RAO)


def _forward_speed() -> Iterator[Check]:
    hull = floating_hull("barge")
    for omega, (heave, pitch) in AT_SPEED.items():
        number = omega**2 / GRAVITY_M_S2
        made = simulation(hull, _wave(omega))
        made.set_state(
            0, _core.BodyState((0.0, 0.0, -hull.waterline_m), (0.0, 0.0, 0.0, 1.0), (-START_M_S, *[0.0] * 5))
        )
        motion = recorded(made, round(hull.settling_s / STEP_S))
        got = [_amplitude(motion, values, omega, number) / CALM_M for values in (motion.heave_m, motion.pitch_rad)]
        tried = (("heave", heave, got[0], HEAVE_AT_SPEED), ("pitch", pitch, got[1] / number, PITCH_AT_SPEED))
        for label, wanted, value, tolerance in tried:
            yield within("Capytaine", f"barge at speed, {label} at {omega:.3g} rad/s", wanted, value, wanted, tolerance)


def _drift() -> Iterator[Check]:
    """Compare the mean force that sets a free hull in motion with that of Capytaine's far field."""
    for name, drifts in DRIFT.items():
        hull = floating_hull(name)
        slow = 1e-3j  # rad/s
        mass = hull.mass[0, 0] + hull.model.added_mass[0, 0] + (hull.model.impedance(slow)[0, 0] / slow).real
        wall = 0.5 * DENSITY_KG_M3 * GRAVITY_M_S2 * WIDTH_M[name]
        for omega, wanted in drifts.items():
            motion = recorded(simulation(hull, _wave(omega)), round(hull.settling_s / STEP_S))
            last = slice(len(motion.x_m) // 2, None)
            time_s, x_m = motion.time_s[last] - motion.time_s[last].mean(), motion.x_m[last]
            phase = omega**2 / GRAVITY_M_S2 * x_m - omega * time_s
            basis = np.column_stack([np.cos(phase), np.sin(phase), np.ones_like(time_s), time_s, 0.5 * time_s**2])
            got = float(mass * np.linalg.lstsq(basis, x_m, rcond=None)[0][4]) / CALM_M**2
            quantity = f"{name}, mean drift at {omega:.3g} rad/s"
            yield within("Capytaine", quantity, wanted, got, wall, DRIFT_ERROR, "N/m2")


def _wave(omega_rad_s: float) -> _core.Waves:
    return _core.Waves.airy(CALM_M, 2.0 * math.pi / omega_rad_s, 0.0, gravity_m_s2=GRAVITY_M_S2)


def _amplitude(motion: Record, values: Array, omega_rad_s: float, number_rad_m: float) -> float:
    """Return the amplitude of the last half of a motion at the phase of the wave where the hull is."""
    last = slice(len(values) // 2, None)
    phase = number_rad_m * motion.x_m[last] - omega_rad_s * motion.time_s[last]
    basis = np.column_stack([np.cos(phase), np.sin(phase), np.ones_like(phase)])
    return float(np.hypot(*np.linalg.lstsq(basis, values[last], rcond=None)[0][:2]))


def _decays() -> Iterator[Check]:
    """Compare a free decay in heave with the solution of Cummins' equation."""
    for name in ("hemisphere", "barge"):
        hull = floating_hull(name)
        motion = recorded(simulation(hull, None, heave_m=CALM_M), round(8.0 / STEP_S))
        exact = motion._replace(heave_m=_decay_m(hull, motion.time_s) - CALM_M)
        group = "decay in heave"
        yield along(group, f"{name}, height", exact.heave_m, motion.heave_m, CALM_M, CLOSED, "m")
        expected, got = _period_and_decrement(exact), _period_and_decrement(motion)
        yield relative(group, f"{name}, period", expected[0], got[0], CLOSED, "s")
        yield relative(group, f"{name}, logarithmic decrement", expected[1], got[1], CLOSED)


def _decay_m(hull: FloatingHull, time_s: Array) -> Array:
    """Return the height of a hull that is released at CALM_M, by the inverse of its Laplace transform.

    Z(s) = (s m + K(s)) z_0 / (s^2 m + s K(s) + c) for m = M + A_infinite; z is real and causal, so it is the cosine
    transform of the real part of Z(i omega).
    """
    omega = np.linspace(1e-4, 80.0, 20_000)
    mass = hull.mass[HEAVE, HEAVE] + hull.model.added_mass[HEAVE, HEAVE]
    s, memory = 1j * omega, np.array([hull.model.impedance(1j * each)[HEAVE, HEAVE] for each in omega])
    transform = (s * mass + memory) * CALM_M / (s**2 * mass + s * memory + hull.stiffness[HEAVE, HEAVE])
    step = omega[1] - omega[0]
    return np.array([2.0 / np.pi * step * float(transform.real @ np.cos(omega * t)) for t in time_s])


def _period_and_decrement(motion: Record) -> tuple[float, float]:
    """Return both of the second swing: its first has what the water remembers of the release."""
    z, t = motion.heave_m + CALM_M, motion.time_s
    zeros = np.flatnonzero(np.diff(np.sign(z)) != 0)[:6]
    crossing = t[zeros] - z[zeros] * (t[zeros + 1] - t[zeros]) / (z[zeros + 1] - z[zeros])
    swings = [np.abs(z[low:high]).max() for low, high in pairwise(zeros)]
    return float(crossing[3] - crossing[1]), 2.0 * math.log(swings[1] / swings[2])


def _haskind() -> Iterator[Check]:
    """Compare the damping with that which the waves' force on the held hull implies."""
    for name in ("hemisphere", "cylinder"):
        hull = floating_hull(name)
        for omega in (3.13, 3.5):
            number = omega**2 / GRAVITY_M_S2
            made = simulation(hull, _wave(omega), held=True)
            period = round(2.0 * math.pi / omega / STEP_S)
            rows = []
            for _ in range(period):
                made.step(1)
                forces = dict(made.forces(0))
                rows.append((1e-9 * made.time_ns, forces["buoyancy"][HEAVE] + forces["diffraction"][HEAVE]))
            time_s, force_n = np.array(rows).T
            basis = np.column_stack([np.cos(omega * time_s), np.sin(omega * time_s), np.ones_like(time_s)])
            force = float(np.hypot(*np.linalg.lstsq(basis, force_n, rcond=None)[0][:2])) / CALM_M
            expected = number * force**2 / (4.0 * DENSITY_KG_M3 * GRAVITY_M_S2 * GRAVITY_M_S2 / (2.0 * omega))
            got = float(hull.model.impedance(1j * omega)[HEAVE, HEAVE].real)
            yield relative(
                "Haskind's relation", f"{name}, damping in heave at {omega:.3g} rad/s", expected, got, HASKIND, "N s/m"
            )


def _energy() -> Iterator[Check]:
    """Damping only takes: at every frequency, and summed over a motion that dives and surfaces."""
    for name in HULLS:
        hull = floating_hull(name)
        real = [np.linalg.eigvalsh(hull.model.impedance(1j * omega).real) for omega in np.geomspace(0.01, 100.0, 200)]
        yield at_most(
            "energy",
            f"{name}, negative damping",
            1e-9,
            float(-min(each[0] for each in real) / max(each[-1] for each in real)),
        )
    hull = floating_hull("hemisphere")
    made = simulation(hull, None)
    made.apply_wrench(0, np.array([0.0, 0.0, -2200.0, 0.0, 0.0, 0.0]), True, 2.0)
    work, most = 0.0, -math.inf
    before = np.asarray(made.state(0).velocity_body)
    for _ in range(round(10.0 / STEP_S)):
        made.step(1)
        after = np.asarray(made.state(0).velocity_body)
        work += STEP_S * float(dict(made.forces(0))["radiation"] @ (before + after)) / 2.0
        most, before = max(most, work), after
    yield at_most("energy", "hemisphere dived and released, work of radiation on it", 1e-3, most / abs(work))


def _irregular() -> Iterator[Check]:
    """Compare the motion in a sea with the sum of the responses to its waves over the same time."""
    waves = _core.Waves.jonswap(depth_m=math.inf, gravity_m_s2=GRAVITY_M_S2, **SEA)
    for name, axes in (("hemisphere", (HEAVE,)), ("barge", (HEAVE, PITCH))):
        hull = floating_hull(name)
        amplitude_m, omega, _, phase = waves.components[waves.components[:, 1] < hull.table.omega_rad_s[-1]].T
        motion = recorded(simulation(hull, waves), round(SEA_S / STEP_S))
        last = slice(len(motion.time_s) // 10, None)
        moved = responses(hull, omega) * (amplitude_m * np.exp(1j * phase))[:, None]
        turning = np.exp(-1j * np.outer(motion.time_s[last], omega))
        for axis in axes:
            got = (motion.heave_m if axis == HEAVE else motion.pitch_rad)[last]
            expected = (turning @ moved[:, axis]).real
            label, unit = ("heave", "m") if axis == HEAVE else ("pitch", "rad")
            quantity = f"{name}, standard deviation of {label}"
            yield relative("irregular waves", quantity, float(expected.std()), float(got.std()), SPECTRUM, unit)
            quantity = f"{name}, mean period of {label}"
            yield relative("irregular waves", quantity, _mean_period_s(expected), _mean_period_s(got), PERIOD, "s")


def _mean_period_s(values: Array) -> float:
    """Return the mean time between upward crossings of 0."""
    ups = np.flatnonzero((values[:-1] < 0.0) & (values[1:] >= 0.0))
    return float((ups[-1] - ups[0]) * STEP_S / (len(ups) - 1))
