"""Compares the density and sound speed of sea water with TEOS-10 (gsw, by the authors of TEOS-10)."""

from __future__ import annotations

import gsw
import numpy as np

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.evidence.validate.check import Check, along
from uwsim.evidence.validate.peers import group

WATERS = 2000
LATITUDE_DEG = 45.0


def checks() -> list[Check]:
    """Return the checks over random waters; the tolerances are those of the EOS-80 generation of equations."""
    draw = np.random.default_rng(0)
    t, s = draw.uniform((-2.0, 0.0), (40.0, 42.0), (WATERS, 2)).T
    density = [_core.sea_water_density_kg_m3(*water) for water in zip(t, s, strict=True)]
    expected = gsw.rho_t_exact(gsw.SR_from_SP(s), t, 0.0)
    name = group("sea_water")
    shallow_m, deep_m = draw.uniform(0.0, 100.0, WATERS), draw.uniform(100.0, 6000.0, WATERS)
    cold, salt = draw.uniform((0.0, 34.0), (6.0, 36.0), (WATERS, 2)).T
    return [
        along(name, "density of the world's surface waters", expected, density, 1.0, 0.02, "kg/m3"),
        along(name, "speed of sound in them, to 100 m", *_sound(t, s, shallow_m), 1.0, 0.3, "m/s"),
        along(name, "speed of sound in the deep sea, to 6 km", *_sound(cold, salt, deep_m), 1.0, 0.5, "m/s"),
    ]


def _sound(t: Floats, s: Floats, depth_m: Floats) -> tuple[Floats, Floats]:
    """Return the peer's and the simulator's speeds of sound at a latitude of 45 degrees."""
    pressure_dbar = gsw.p_from_z(-depth_m, LATITUDE_DEG)
    expected = gsw.sound_speed_t_exact(gsw.SR_from_SP(s), t, pressure_dbar)
    got = [_core.sound_speed_m_s(*water) for water in zip(t, s, depth_m, strict=True)]
    return np.asarray(expected), np.array(got)
