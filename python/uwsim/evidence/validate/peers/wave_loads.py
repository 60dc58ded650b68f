"""Compares the wave loads and added mass of packaged hulls with Capytaine, a panel code for potential flow.

Capytaine 3.0.0 (Ancellin and Dias 2019, "Capytaine: a Python-based linear potential flow solver", J. Open Source
Software 4:1341) computed the stored results; tests/python/data/README.md has the recipe. Each hull is submerged, held
at rest, and has Capytaine's added mass in unbounded water, so the check tests the load model rather than the vehicle's
coefficients: undisturbed pressure plus added mass times the water's acceleration, in place of diffraction.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.base.axes import AXES
from uwsim.base.texts.json_text import read_json
from uwsim.evidence.validate.check import Check, relative, within
from uwsim.scenario import load_vehicle
from uwsim.scenario.build.hull import rigid_body, vehicle_hull

RESULTS = Path(__file__).parent / "capytaine_hulls.json"
AMPLITUDE_M = 0.005
HEAD = {"surge": 0, "heave": 2, "pitch": 4}
BEAM = {"sway": 1, "heave": 2}
SLENDER = "remus100"
KINDS = {"froude_krylov": ("waves' pressure", 0.02), "excitation": ("whole load", 0.1)}
MOMENTS = 0.05


def checks() -> list[Check]:
    """Return the checks of all hulls: the worst wavelength of each component, and the slender hull's added mass.

    Force errors are relative to the largest force along the axis, moment errors to the largest heave force times half
    the hull's length.
    """
    kept = read_json(RESULTS)
    group = f"Capytaine {kept['capytaine']}"
    found = []
    for name, hull in kept["hulls"].items():
        half_m = 0.5 * float(np.ptp(vehicle_hull(load_vehicle(name))[0][:, 0]))
        for label, direction_deg, axes in (("head", 0.0, HEAD), ("beam", 90.0, BEAM)):
            waves = [wave for wave in hull["waves"] if wave["direction_deg"] == direction_deg]
            for kind, (what, tolerance) in KINDS.items():
                got = np.array([amplitudes(name, hull, wave, kept, kind == "excitation") for wave in waves])
                expected = np.array([wave[kind] for wave in waves])
                for axis, k in axes.items():
                    scale = expected[:, k].max() if k < 3 else expected[:, 2].max() * half_m
                    worst = int(np.argmax(np.abs(got[:, k] - expected[:, k])))
                    quantity = f"{name}, {label} waves of {waves[worst]['wavelength_m']:.1f} m: {what}, {axis}"
                    pair = expected[worst, k], got[worst, k]
                    found.append(
                        within(group, quantity, *pair, scale, tolerance if k < 3 else MOMENTS, f"{unit_of(k)}/m")
                    )
    added = np.diag(kept["hulls"][SLENDER]["added_mass"])
    model = load_vehicle(SLENDER)
    assert model.added_mass is not None
    return found + [
        relative(group, f"{SLENDER}, added mass in {AXES[k]}", added[k], model.added_mass[k], 0.15, added_unit)
        for k, added_unit in ((1, "kg"), (2, "kg"), (4, "kg m2"), (5, "kg m2"))
    ]


def unit_of(axis: int) -> str:
    """Return the unit of a component of a wrench."""
    return "N" if axis < 3 else "N m"


def amplitudes(name: str, hull: dict[str, Any], wave: dict[str, Any], kept: dict[str, Any], with_added: bool) -> Floats:
    """Return the amplitudes (6,) of the load per metre of wave amplitude, N/m and N m/m about the body's origin."""
    density, gravity = kept["density_kg_m3"], kept["gravity_m_s2"]
    model = load_vehicle(name)
    body = rigid_body(model, density)
    parameters = _core.CraftParameters()
    parameters.mass_kg = density * body.volume_m3
    parameters.inertia_kg_m2 = np.diag(body.inertia_kg_m2)
    added = np.array(hull["added_mass"]) * with_added
    parameters.added_mass = 0.5 * (added + added.T)
    craft = _core.Craft(parameters, *vehicle_hull(model))
    mass = np.array(parameters.added_mass)
    mass[:3, :3] += parameters.mass_kg * np.eye(3)
    mass[3:, 3:] += parameters.inertia_kg_m2
    period_s = math.sqrt(2 * math.pi * wave["wavelength_m"] / gravity)
    water = _core.Water()
    water.density_kg_m3, water.gravity_m_s2 = density, gravity
    water.waves = _core.Waves.airy(AMPLITUDE_M, period_s, math.radians(wave["direction_deg"]), gravity_m_s2=gravity)
    state = _core.BodyState([0.0, 0.0, -hull["depth_m"]], [0.0, 0.0, 0.0, 1.0], [0.0] * 6)

    def load(time_s: float) -> Floats:
        return np.asarray(mass @ craft.acceleration_body(state, np.zeros(6), water, time_s))

    first, second = ((load(t) - load(t + period_s / 2)) / 2 for t in (0.0, period_s / 4))
    return np.asarray(np.hypot(first, second) / AMPLITUDE_M)
