"""The tether suite: MoorDyn's shapes and tensions at rest, and peaks of tension when a falling mass is stopped.

tests/python/data/make_moordyn_tethers.py computed the stored results with MoorDyn 2.7.2, with as many elements.
MoorDyn was given our own cables: it judges equations. Closed forms are native tests: Tether.HangsInACatenary,
LiesAtTheCriticalAngleInACurrent, IsHeldByTheBedsFriction, CarriesLongitudinalWaves.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from uwsim import _core
from uwsim.base.texts.json_text import read_json
from uwsim.evidence.validate.check import Check, relative, within

RESULTS = Path(__file__).parent / "moordyn_tethers.json"
GROUP = "MoorDyn 2.7.2"
DEPTH_M, SIDE_M = 60.0, 0.1
STILL_S, STILL_STEP_S, SNAP_STEP_S = 5.0, 0.01, 0.0005
AT_REST, IN_SNAP = 0.01, 0.05
"""Tolerances. Shapes are relative to the tether's length."""


def run() -> list[Check]:
    """Return the checks of all stored cases."""
    stored = read_json(RESULTS)
    still = [check for case in stored["still"] for check in _at_rest(case)]
    return still + [check for case in stored["snaps"] for check in _in_snap(case)]


def _at_rest(case: dict[str, Any]) -> list[Check]:
    simulation = _simulation(STILL_STEP_S)
    simulation.add_tether(_spec(case, _core.TetherEnd(case["end_m"])))
    simulation.step(round(STILL_S / STILL_STEP_S))
    now = simulation.tether(0)
    points = np.array(now.points_world_m)[:: case["segments"] // (len(case["points_m"]) - 1)]
    apart_m = np.linalg.norm(points - case["points_m"], axis=1).max()
    name, (first, second) = f"a tether at rest, {case['name']}", case["end_tensions_n"]
    return [
        within(GROUP, f"{name}: shape", 0.0, float(apart_m), case["length_m"], AT_REST, "m"),
        relative(GROUP, f"{name}: tension of its first element", first, float(now.tensions_n[0]), AT_REST, "N"),
        relative(GROUP, f"{name}: tension of its last element", second, float(now.tensions_n[-1]), AT_REST, "N"),
    ]


def _in_snap(case: dict[str, Any]) -> list[Check]:
    simulation = _simulation(SNAP_STEP_S)
    simulation.add_object(_mass(case["mass_kg"], case["end_m"]))
    simulation.add_tether(_spec(case, _core.TetherEnd((0.0, 0.0, 0.0), 0)))
    peak_n, lowest_m = 0.0, 0.0
    for _ in range(round(case["duration_s"] / SNAP_STEP_S)):
        simulation.step(1)
        now = simulation.tether(0)
        peak_n = max(peak_n, float(np.linalg.norm(now.end_forces_n[0])))
        lowest_m = min(lowest_m, float(now.points_world_m[-1][2]))
    start_m = case["start_m"][2]
    return [
        relative(GROUP, f"{case['name']}: greatest tension", case["peak_tension_n"], peak_n, IN_SNAP, "N"),
        relative(GROUP, f"{case['name']}: deepest", start_m - case["lowest_m"], start_m - lowest_m, AT_REST, "m"),
    ]


def _simulation(step_s: float) -> _core.Simulation:
    world = _core.World()
    world.set_terrain(np.full((2, 2), -DEPTH_M, np.float32), 400.0, (-200.0, -200.0))
    spec = _core.SimulationSpec()
    spec.step_s = step_s
    return _core.Simulation(world, _core.RayScene(world), spec)


def _spec(case: dict[str, Any], end: _core.TetherEnd) -> _core.TetherSpec:
    spec = _core.TetherSpec()
    spec.first, spec.second = _core.TetherEnd(case["start_m"]), end
    spec.length_m, spec.elements = case["length_m"], case["segments"]
    spec.bending_stiffness_n_m2 = spec.friction = 0.0
    spec.axial_damping_n_s = 100.0
    for name, value in case["line"].items():
        setattr(spec, name, value)
    return spec


def _mass(mass_kg: float, position_m: list[float]) -> _core.ObjectSpec:
    """Return a cube so small that water does not act on it."""
    from uwsim.base.whole_trimesh import trimesh

    cube = trimesh.creation.box((SIDE_M / 100, SIDE_M / 100, SIDE_M / 100))
    parameters = _core.CraftParameters()
    parameters.mass_kg = mass_kg
    parameters.inertia_kg_m2 = np.eye(3) * mass_kg
    craft = _core.Craft(parameters, np.asarray(cube.vertices), np.asarray(cube.faces, np.uint32))
    state = _core.BodyState(position_m, (0.0, 0.0, 0.0, 1.0), np.zeros(6))
    return _core.ObjectSpec("mass", craft, _core.CollisionShape.HULL, 0.5, 0.0, state)
