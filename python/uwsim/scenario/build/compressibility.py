"""The displacement of a compressible hull at depth, in water that may itself be compressible."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.scenario.build.gravity import gravity_m_s2
from uwsim.scenario.build.terrain import build_terrain
from uwsim.scenario.build.water import build_water
from uwsim.scenario.georeference import georeference
from uwsim.scenario.spec.scenario import Scenario

STEP_M = 25.0  # keeps the relative error of linear interpolation below 1e-8


def buoyancy_share(scenario: Scenario, compressibility_1_pa: float) -> NDArray[np.float64]:
    """Return the buoyancy of a submerged hull relative to that at surface pressure, every STEP_M down to the bed.

    (n,): rho(z) V(z) / (rho_0(z) V_0). If the water is compressible, its density increases with pressure by EOS-80
    (sea_water.h). The volume follows dV / V = -compressibility dp, so V = V_0 exp(-compressibility p) at gauge pressure
    p.
    """
    terrain = build_terrain(scenario.terrain).window(scenario.terrain.window_m)
    gravity = gravity_m_s2(scenario.earth)
    water = build_water(
        scenario.water, bottom_depth_m=-terrain.lowest_m, seed=scenario.seed, gravity_m_s2=gravity,
        place=partial(georeference, scenario),
    )  # fmt: skip
    depths_m = STEP_M * np.arange(int(np.ceil(-terrain.lowest_m / STEP_M)) + 1)
    return np.array([_share(water, -depth, compressibility_1_pa) for depth in depths_m.tolist()])


def _share(water: _core.Water, z_m: float, compressibility_1_pa: float) -> float:
    gauge_pa = water.pressure_pa(z_m) - water.atmospheric_pressure_pa
    squeezed = 1.0
    if water.compressible:
        state = water.temperature_deg_c(z_m), water.salinity_at_psu(z_m)
        squeezed = _core.sea_water_density_kg_m3(*state, gauge_pa) / _core.sea_water_density_kg_m3(*state)
    return squeezed * float(np.exp(-compressibility_1_pa * gauge_pa))
