"""Predicts the vertical speeds of two Slocums in half of their glides; the other half gave their coefficients.

Flights of amadeus and sebastian in the German Bight, 2014, which dbdreader reads, a peer and not a dependency. A glide
has a full pump, either way; of it, windows of about a minute between 18 and 35 dbar count, where the water is uniform.
Two glides are in the one half, the next two in the other. Each glider's ballast, one number, follows from the first
half. Steady forces are quadratic in speed: at one pitch the vertical speed goes with the root of the net weight.
"""

from __future__ import annotations

import warnings
from dataclasses import replace
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from uwsim.base.arrays import Floats
from uwsim.evidence.validate.check import Check, Curve, relative
from uwsim.evidence.validate.flights import deep_water
from uwsim.evidence.validate.reality.kinds import PREDICTED
from uwsim.scenario import VehicleModel, load_vehicle

Simulated = tuple[Floats, Floats, float]
"""The result of simulated_glides()."""
GLIDERS = ("amadeus", "sebastian")
FILE = "slocum/amadeus-2014-204-05-000.dbd"
GROUP = f"{PREDICTED}: Slocum, glides"
WATER_KG_M3, GRAVITY_M_S2, PA_PER_BAR = 1025.0, 9.80665, 1e5
FULL_CM3, SETTLE_S, LEAST_GLIDE_S, WINDOW_S = 215.0, 45.0, 120.0, 60.0
DEEP_DBAR, LEAST_DBAR, LEAST_ROWS = (18.0, 35.5), 8.0, 6
MOVED, GLIDE_S = (0.05, 0.1, 0.15, 0.2, 0.25, 0.3), 200.0
"""Shares by which the simulated battery is moved, to cover the gliders' pitches."""
TOLERANCE = 0.05


class Windows(NamedTuple):
    """Windows of steady glides (n,): number of the glide, speed upward [m/s], pitch [rad], pumped volume [cm3]."""

    glide: NDArray[np.intp]
    rises_m_s: Floats
    pitch_rad: Floats
    pumped_cm3: Floats

    def of(self, chosen: NDArray[np.bool_]) -> Windows:
        """Return some of the windows."""
        return Windows(self.glide[chosen], self.rises_m_s[chosen], self.pitch_rad[chosen], self.pumped_cm3[chosen])


def checks(data: Path) -> list[Check]:
    """Return the checks."""
    if find_spec("dbdreader") is None:
        warnings.warn("validate reality: glides is left out: needs `pip install dbdreader`", stacklevel=2)
        return []
    found = []
    simulated = simulated_glides(load_vehicle("slocum"))
    for name in GLIDERS:
        windows = windows_of(data / f"slocum/{name}-2014-204-05-000.dbd", data / "slocum/cac")
        given = (windows.glide // 2) % 2 == 0
        held = windows.of(~given)
        predicted = rises_m_s(held, ballast_kg(windows.of(given), simulated), simulated)
        for text, chosen in (("sinking", held.pumped_cm3 < 0), ("climbing", held.pumped_cm3 > 0)):
            measured, ours = float(held.rises_m_s[chosen].mean()), float(predicted[chosen].mean())
            check = relative(GROUP, f"{name}: mean speed {text}", measured, ours, TOLERANCE, "m/s")
            lines = {"measured": held.rises_m_s[chosen], "predicted": predicted[chosen]}
            curve = Curve(np.arange(chosen.sum()), lines, "window", "m/s")
            found.append(replace(check, curve=curve))
    return found


def rises_m_s(windows: Windows, ballast: float, simulated: Simulated) -> Floats:
    """Return the predicted speeds upward (n,) of a glider with some ballast [kg], positive if it floats."""
    pitches_rad, sinking_m_s, full_n = simulated
    net_n = GRAVITY_M_S2 * (1e-6 * WATER_KG_M3 * windows.pumped_cm3 + ballast)
    steady = np.interp(np.abs(windows.pitch_rad), pitches_rad, sinking_m_s)
    return np.asarray(np.sign(net_n) * np.sqrt(np.abs(net_n) / full_n) * steady, np.float64)


def ballast_kg(windows: Windows, simulated: Simulated) -> float:
    """Return the ballast with which the predicted speeds are closest to those of some windows."""

    def misfit(ballast: float) -> float:
        return float(((rises_m_s(windows, ballast, simulated) - windows.rises_m_s) ** 2).sum())

    return float(minimize_scalar(misfit, (0.0, 0.2)).x)


def simulated_glides(model: VehicleModel) -> Simulated:
    """Return pitches (n,) [rad], rising, and vertical speeds (n,) of steady glides at full pump, and its force [N]."""
    rows = []
    for moved in MOVED:
        sim = deep_water(model, density_kg_m3=WATER_KG_M3, step_s=0.02)
        sim.rov.set_thrusters({"pump": -1.0, "battery": -moved})
        sim.advance(GLIDE_S)
        turn = sim.rov.pose.world_from_body[:3, :3]
        rows.append((-np.arcsin(turn[2, 0]), -(turn @ sim.rov.velocity.linear_body_m_s)[2]))
    pitches, speeds = np.array(rows).T
    return pitches, speeds, max(thrust_n for _, thrust_n in model.thrusters["pump"].model.thrust_n)


def windows_of(path: Path, cache: Path) -> Windows:
    """Return the windows of a flight. cache: the folder with its description (.cac). Raises what dbdreader raises."""
    log = import_module("dbdreader").DBD(str(path), cacheDir=str(cache))
    times_s, bar = log.get("m_pressure")
    pitch, pumped = (np.interp(times_s, *log.get(name)) for name in ("m_pitch", "m_ballast_pumped"))
    log.close()
    return split(np.asarray(times_s), np.asarray(bar), pitch, pumped)


def split(times_s: Floats, bar: Floats, pitch_rad: Floats, pumped_cm3: Floats) -> Windows:
    """Return the windows of a record (n,)."""
    sign = np.where(np.abs(pumped_cm3) > FULL_CM3, np.sign(pumped_cm3), 0.0)
    edges = np.flatnonzero(np.diff(sign)) + 1
    rows: list[tuple[float, ...]] = []
    glide = 0
    for part in np.split(np.arange(len(times_s)), edges):
        span_s = times_s[part[-1]] - times_s[part[0]]
        dbar = 10.0 * bar[part]
        low, high = DEEP_DBAR
        kept = part[(times_s[part] > times_s[part[0]] + SETTLE_S) & (dbar > low) & (dbar < high)]
        if sign[part[0]] == 0 or span_s < LEAST_GLIDE_S or len(kept) <= 10 or 10 * np.ptp(bar[kept]) < LEAST_DBAR:
            continue
        count = max(1, int((times_s[kept[-1]] - times_s[kept[0]]) // WINDOW_S))
        for at in np.array_split(kept, count):
            if len(at) >= LEAST_ROWS:
                falls = np.polyfit(times_s[at] - times_s[at[0]], bar[at], 1)[0] * PA_PER_BAR
                rises_m_s = -falls / (WATER_KG_M3 * GRAVITY_M_S2)
                rows.append((glide, rises_m_s, pitch_rad[at].mean(), pumped_cm3[at].mean()))
        glide += 1
    table = np.array(rows).reshape(-1, 4)
    return Windows(table[:, 0].astype(np.intp), *table[:, 1:].T)
