"""A hull with a compressibility displaces rho(p) V_0 exp(-compressibility p); by default it shrinks with the water."""

from pathlib import Path

import numpy as np
import pytest

from uwsim import Simulator, _core
from uwsim.scenario import ScenarioError
from uwsim.scenario.build.vehicle import vehicle_spec
from uwsim.scenario.read.assets import assets_folder

DEEP_M, G = 990.0, 9.80665
AT_REST = np.zeros(6)


def deep(folder: Path, extra: str = "", water: str = "") -> Simulator:
    assets = assets_folder()
    scenario = (assets / "scenarios" / "pool.yaml").read_text()
    vehicle = (assets / "vehicles" / "rov.yaml").read_text().replace("mesh: ", f"mesh: {assets}/")
    (folder / "squeezed.yaml").write_text(vehicle + extra)
    text = scenario.replace("model: rov", "model: squeezed.yaml").replace("water:\n", "water:\n" + water)
    path = folder / "deep.yaml"
    path.write_text(text.replace("bed_depth_m: 5", "bed_depth_m: 1000"))
    return Simulator(path)


def heave_m_s2(sim: Simulator, force_n: float = 0.0) -> float:
    """Return the heave acceleration at rest and level, with the centre of buoyancy about DEEP_M deep."""
    craft = vehicle_spec(sim.scenario, sim.scenario.vehicles[0]).craft
    state = _core.BodyState((0.0, 0.0, -DEEP_M), (0.0, 0.0, 0.0, 1.0), AT_REST)
    return float(craft.acceleration_body(state, np.array([0, 0, force_n, 0, 0, 0.0]), sim.world.water)[2])


def pressure_and_squeeze(sim: Simulator) -> tuple[float, float]:
    """Return the gauge pressure and rho / rho_0 at DEEP_M, by summing the weight of thin layers."""
    water, pressure_pa, step_m = sim.world.water, 0.0, 1.0

    def squeeze(depth_m: float) -> float:
        state = water.temperature_deg_c(-depth_m), water.salinity_at_psu(-depth_m)
        return _core.sea_water_density_kg_m3(*state, pressure_pa) / _core.sea_water_density_kg_m3(*state)

    for depth_m in np.arange(0.5 * step_m, DEEP_M, step_m).tolist():
        pressure_pa += G * float(water.density_at_kg_m3(-depth_m)) * squeeze(depth_m) * step_m
    return pressure_pa, squeeze(DEEP_M)


@pytest.mark.parametrize("compressibility_1_pa", [0.0, 3e-10, 1e-9])
def test_the_displaced_weight_at_depth_is_that_of_the_squeezed_volume_of_squeezed_water(
    compressibility_1_pa: float, tmp_path: Path
) -> None:
    plain, sim = deep(tmp_path), deep(tmp_path, f"compressibility_1_pa: {compressibility_1_pa}\n")
    craft = vehicle_spec(sim.scenario, sim.scenario.vehicles[0]).craft
    pressure_pa, squeeze = pressure_and_squeeze(sim)
    weight_n = float(sim.world.water.density_at_kg_m3(-DEEP_M)) * G * craft.volume_m3
    gained_n = weight_n * (squeeze * np.exp(-compressibility_1_pa * pressure_pa) - 1.0)
    assert heave_m_s2(sim) - heave_m_s2(plain) == pytest.approx(
        heave_m_s2(plain, gained_n) - heave_m_s2(plain), rel=2e-3
    )


def test_a_rigid_hull_gains_half_a_percent_at_a_kilometre_and_nothing_in_water_that_does_not_compress(
    tmp_path: Path,
) -> None:
    _, squeeze = pressure_and_squeeze(deep(tmp_path))
    assert squeeze == pytest.approx(1.0046, abs=2e-4)
    stiff = heave_m_s2(deep(tmp_path, "compressibility_1_pa: 0\n", "  compressible: false\n"))
    assert stiff == pytest.approx(heave_m_s2(deep(tmp_path, "", "  compressible: false\n")), abs=1e-12)


def test_it_is_a_parameter_while_the_simulator_runs(tmp_path: Path) -> None:
    sim = deep(tmp_path, "compressibility_1_pa: 0\n")
    sim.parameters["rov.compressibility_1_pa"] = 1e-9
    sim.rov.place((0.0, 0.0, -DEEP_M))
    sim.step(20)
    sinking = sim.rov.velocity.linear_body_m_s[2]
    other = deep(tmp_path, "compressibility_1_pa: 0\n")
    other.rov.place((0.0, 0.0, -DEEP_M))
    other.step(20)
    assert sinking < other.rov.velocity.linear_body_m_s[2] - 1e-3


def test_a_negative_compressibility_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="compressibility_1_pa = -1"):
        deep(tmp_path, "compressibility_1_pa: -1\n")
