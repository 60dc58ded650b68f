"""The CTD: its conductivity is that of TEOS-10's library, and its salinity that of the water, with the three errors."""

from pathlib import Path

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.scenario import load
from uwsim.scenario.spec.sensor import SensorMount

SCENE = """
name: sea
mission_time_s: 600
water:
  profile:
    kind: table
    levels:
      - {depth_m: 0, temperature_deg_c: 24, salinity_psu: 38}
      - {depth_m: 20, temperature_deg_c: 9, salinity_psu: 34}
      - {depth_m: 60, temperature_deg_c: 4, salinity_psu: 35}
terrain: {source: noise, size_m: [40, 40], spacing_m: 1, bed_depth_m: 60}
station: {position_m: [-6, 0, 0], dock_m: [0, 0, DOCK]}
vehicles: [{name: rov, model: rov, start: station}]
"""


def at_depth(folder: Path, dock_m: float, **noise: dict[str, float]) -> Simulator:
    (folder / "sea.yaml").write_text(SCENE.replace("DOCK", str(dock_m)))
    scenario = load(folder / "sea.yaml")
    ctd = SensorMount.model_validate({"kind": "ctd", "rate_hz": 8, "position_m": [0.2, 0, 0], "channels": noise})
    model = scenario.vehicles[0].model.model_copy(update={"sensors": {"ctd": ctd}})
    vehicle = scenario.vehicles[0].model_copy(update={"model": model})
    return Simulator(scenario.model_copy(update={"vehicles": (vehicle,)}))


@pytest.mark.parametrize("dock_m", [-2, -19, -45])
def test_conductivity_is_that_of_another_library(tmp_path, dock_m):
    gsw = pytest.importorskip("gsw", reason="needs gsw, the TEOS-10 library, which is not a dependency")
    sim = at_depth(tmp_path, dock_m)
    read = sim.rov.sensors["ctd"].read(noise=False)
    z_m = float(sim.rov.pose.position_world_m[2])
    salinity = sim.world.water.salinity_at_psu(z_m)
    assert read.salinity_psu == pytest.approx(salinity, abs=1e-6)
    other = gsw.C_from_SP(salinity, read.temperature_deg_c, read.pressure_dbar)
    assert read.conductivity_ms_cm == pytest.approx(other, rel=1e-6)
    again = gsw.SP_from_C(read.conductivity_ms_cm, read.temperature_deg_c, read.pressure_dbar)
    assert read.salinity_psu == pytest.approx(again, abs=1e-6)


def test_an_error_of_temperature_is_one_of_salinity(tmp_path):
    """Near 15 deg C and 35 psu, salinity changes by some -0.9 psu per degree at the same conductivity."""
    sim = at_depth(tmp_path, -19, temperature={"std": 0.05})
    sim.advance(1.0)
    errors = []
    for _ in range(200):
        sim.advance(0.125)
        read, true = sim.rov.sensors["ctd"].read(), sim.rov.sensors["ctd"].read(noise=False)
        errors.append((read.temperature_deg_c - true.temperature_deg_c, read.salinity_psu - true.salinity_psu))
    warm, salt = np.array(errors).T
    assert warm.std() == pytest.approx(0.05, rel=0.2)
    assert np.polyfit(warm, salt, 1)[0] == pytest.approx(-0.97, abs=0.1)
