"""The suite `tether`: laws of cables in closed form, and the stored results of MoorDyn.

The catenary is the elastic one of Irvine (1981, "Cable Structures", 2.2), the angle in a current that of Pode (1951,
DTMB report 687).
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.evidence.validate.check import Check, relative, within
from uwsim.evidence.validate.peers import tethers

GROUP = "closed forms"
GRAVITY_M_S2, WATER_KG_M3 = 9.80665, 1000.0
EXACT, WAVES = 0.003, 0.01
"""Tolerances."""


def run(out: Path | None = None) -> list[Check]:
    """Return the checks. It draws nothing."""
    return [*_catenaries(), *_current(), *_grounded(), *_waves(), *tethers.checks()]


def _spec(
    first: tuple[float, float, float], second: tuple[float, float, float], length_m: float, elements: int
) -> _core.TetherSpec:
    spec = _core.TetherSpec()
    spec.first, spec.second = _core.TetherEnd(first), _core.TetherEnd(second)
    spec.length_m, spec.elements = length_m, elements
    spec.diameter_m, spec.mass_kg_m, spec.axial_stiffness_n = 0.02, 1.0, 1e6
    spec.bending_stiffness_n_m2 = 0.0
    return spec


def _wet_weight_n_m(spec: _core.TetherSpec) -> float:
    return GRAVITY_M_S2 * (spec.mass_kg_m - WATER_KG_M3 * math.pi / 4.0 * spec.diameter_m**2)


def _simulation(step_s: float, depth_m: float = 80.0, water: _core.Water | None = None) -> _core.Simulation:
    world = _core.World()
    world.set_terrain(np.full((2, 2), -depth_m, np.float32), 400.0, (-200.0, -200.0))
    if water is not None:
        world.water = water
    spec = _core.SimulationSpec()
    spec.step_s = step_s
    return _core.Simulation(world, _core.RayScene(world), spec)


def _catenary(
    along_m: NDArray[np.float64] | float, level_n: float, low_n: float, weight_n_m: float, stiffness_n: float
) -> NDArray[np.float64]:
    """Return the points (..., 2) at lengths from the lower end: horizontal and vertical [m]."""
    s = np.asarray(along_m, float)
    v = low_n + weight_n_m * s
    x = level_n * s / stiffness_n + level_n / weight_n_m * (np.arcsinh(v / level_n) - math.asinh(low_n / level_n))
    z = (v**2 - low_n**2) / (2.0 * weight_n_m * stiffness_n)
    return np.stack([x, z + (np.hypot(level_n, v) - math.hypot(level_n, low_n)) / weight_n_m], axis=-1)


def _catenaries() -> list[Check]:
    found = []
    for stiffness_n in (1e6, 1e4):
        spec = _spec((0.0, 0.0, -50.0), (0.0, 0.0, -50.0), 60.0, 100)
        spec.axial_stiffness_n = stiffness_n
        weight_n_m, level_n, low_n = _wet_weight_n_m(spec), 200.0, -100.0
        shape = _catenary(np.linspace(0.0, 60.0, 101), level_n, low_n, weight_n_m, stiffness_n)
        x, z = shape[-1].tolist()
        spec.second = _core.TetherEnd((x, 0.0, -50.0 + z))
        simulation = _simulation(0.01)
        simulation.add_tether(spec)
        simulation.step(200)
        now = simulation.tether(0)
        points = np.array(now.points_world_m)[:, [0, 2]] + [0.0, 50.0]
        apart_m = float(np.linalg.norm(points - shape, axis=1).max())
        name = f"catenary of {stiffness_n:g} N"
        pull = -np.array(now.end_forces_n[1])
        found += [
            within(GROUP, f"{name}: shape", 0.0, apart_m, 60.0, EXACT, "m"),
            relative(GROUP, f"{name}: horizontal force", level_n, float(pull[0]), EXACT, "N"),
            relative(GROUP, f"{name}: vertical force", low_n + 60.0 * weight_n_m, float(pull[2]), EXACT, "N"),
        ]
    return found


def critical_angle_rad(weight_n_m: float, drag_n_m: float) -> float:
    """Return the angle below the flow at which a cable's weight balances the drag across it (Pode 1951).

    drag_n_m: of the cable at right angles to the flow.
    """
    return math.acos((-weight_n_m + math.sqrt(weight_n_m**2 + 4.0 * drag_n_m**2)) / (2.0 * drag_n_m))


def _current() -> list[Check]:
    """A cable with a free end in a current takes the critical angle."""
    water = _core.Water()
    water.current_world_m_s = (0.8, 0.0, 0.0)
    spec = _spec((0.0, 0.0, -20.0), (0.0, 0.0, -40.0), 20.0, 40)
    simulation = _simulation(0.02, water=water)
    simulation.add_tether(spec)
    simulation.cut_tether(0, 20.0)
    simulation.step(12_000)
    drag_n_m = 0.5 * WATER_KG_M3 * spec.normal_drag * spec.diameter_m * 0.8**2
    angle_rad = critical_angle_rad(_wet_weight_n_m(spec), drag_n_m)
    points = np.array(simulation.tether(0).points_world_m)
    along = (points[21] - points[20]) / np.linalg.norm(points[21] - points[20])
    return [relative(GROUP, "angle of a free cable in a current", angle_rad, math.acos(along[0]), EXACT, "rad")]


def _grounded() -> list[Check]:
    """On a bed with friction, tension changes by friction times weight along what slides (as for an anchor chain)."""
    spec = _spec((0.0, 0.0, -19.9), (60.0, 0.0, -19.9), 60.5, 60)
    spec.friction, spec.fastest_m_s = 0.4, 1.0
    simulation = _simulation(0.01, 20.0)
    simulation.add_tether(spec)
    simulation.command_winch(0, rate_m_s=-0.01)
    simulation.step(4000)
    now = simulation.tether(0)
    points, tensions = np.array(now.points_world_m), np.array(now.tensions_n)
    lies = points[:, 2] < -19.99  # a radius above the bed, or less
    slides = lies[:-2] & lies[1:-1] & lies[2:] & (tensions[:-1] > 0.0) & (tensions[1:] > 0.0)
    falls = -np.diff(tensions)[slides]
    limit = spec.friction * _wet_weight_n_m(spec) * spec.length_m / spec.elements
    name = "fall of tension along a cable that slides on the bed, per element, median"
    return [relative(GROUP, name, limit, float(np.median(falls)), EXACT, "N")]


def _waves() -> list[Check]:
    """A jump of tension runs along a cable without weight in water at the speed of longitudinal waves.

    Transverse waves are a native test, TEST(Tether, CarriesTransverseWaves).
    """
    spec = _spec((0.0, 0.0, -10.0), (100.0, 0.0, -10.0), 100.0, 400)
    spec.diameter_m = math.sqrt(4.0 / math.pi * spec.mass_kg_m / WATER_KG_M3)
    spec.axial_stiffness_n, spec.axial_damping_n_s, spec.tangential_drag, spec.fastest_m_s = 1e5, 0.0, 0.0, 10.0
    simulation = _simulation(2e-5)
    simulation.add_tether(spec)
    simulation.command_winch(0, rate_m_s=-0.1)
    jump_n = 0.1 * math.sqrt(spec.axial_stiffness_n * spec.mass_kg_m)
    steps = 0
    while steps < 30_000 and simulation.tether(0).tensions_n[-1] < jump_n:
        simulation.step(20)
        steps += 20
    speed = math.sqrt(spec.axial_stiffness_n / spec.mass_kg_m)
    return [relative(GROUP, "speed of longitudinal waves", speed, 100.0 / (steps * 2e-5), WAVES, "m/s")]
