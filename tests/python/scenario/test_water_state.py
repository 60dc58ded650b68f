"""Density, temperature and salinity agree: a missing one is derived with EOS-80; contradictions are refused."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from uwsim import Simulator, _core
from uwsim.scenario import Scenario, ScenarioError, load
from uwsim.scenario.build.water import build_water, surface_density_kg_m3
from uwsim.scenario.fingerprint import scenario_fingerprint
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.water import Water

SEA_KG_M3 = _core.sea_water_density_kg_m3(15.0, 35.0)
HEAVY_M3, HEAVY_KG, HEAVY_ADDED_KG = 0.0134, 13.5, 18.6863


def built(values: dict[str, Any], bottom_m: float = 30.0, folder: Path | None = None) -> _core.Water:
    return build_water(validated(Water, values, folder=folder), bottom_depth_m=bottom_m, seed=0)


def refusal(values: dict[str, Any], bottom_m: float = 30.0, folder: Path | None = None) -> str:
    with pytest.raises(ScenarioError) as caught:
        built(values, bottom_m, folder)
    return str(caught.value)


def in_water(model: str = "bluerov2_heavy", **water: Any) -> Scenario:
    vehicle = {"name": "rov", "model": model, "start": {"position_m": [0, 0, -5]}}
    terrain = {"source": "noise", "size_m": [40, 40], "spacing_m": 2, "bed_depth_m": 12}
    return Scenario.model_validate({"name": "water", "water": water, "terrain": terrain, "vehicles": [vehicle]})


def test_density_follows_from_temperature_and_salinity() -> None:
    for t in (-2.0, 4.0, 15.0, 29.0, 40.0):
        for s in (0.0, 7.0, 35.0, 45.0):
            given = {"surface_temperature_deg_c": t, "salinity_psu": s}
            water = built(given)
            assert water.salinity_psu == s
            assert water.density_at_kg_m3(-3.0) == _core.sea_water_density_kg_m3(t, s)
            assert surface_density_kg_m3(validated(Water, given)) == water.density_kg_m3
    assert built({}).density_kg_m3 == _core.sea_water_density_kg_m3(15.0, 0.0)


def test_a_vehicle_weighted_for_the_sea_rises_in_salt_water() -> None:
    sim = Simulator(in_water(salinity_psu=35))
    net_n = (SEA_KG_M3 * HEAVY_M3 - HEAVY_KG) * 9.80665
    assert net_n == pytest.approx(2.4, abs=0.1)
    sim.advance(0.2)
    rise_m_s = sim.rov.velocity.linear_body_m_s[2]
    assert rise_m_s == pytest.approx(net_n / (HEAVY_KG + HEAVY_ADDED_KG) * 0.2, rel=0.15)


def test_a_neutral_vehicle_has_the_mass_of_the_salt_water_that_it_displaces() -> None:
    fresh, salt = (Simulator(in_water("rov", salinity_psu=s)).parameters["rov.mass_kg"] for s in (0, 35))
    assert salt / fresh == pytest.approx(SEA_KG_M3 / _core.sea_water_density_kg_m3(15.0, 0.0), rel=1e-12)


def test_a_density_alone_is_that_of_fresh_water_or_gives_the_salinity() -> None:
    for density in (997.0, 1000.0, 1004.0, 991.0):
        water = built({"density_kg_m3": density})
        assert (water.density_kg_m3, water.salinity_psu) == (density, 0.0)
    sea = built({"density_kg_m3": 1025.0})
    assert _core.sea_water_density_kg_m3(15.0, sea.salinity_psu) == pytest.approx(1025.0, abs=1e-6)
    assert sea.sound_speed_m_s(0.0) == pytest.approx(_core.sound_speed_m_s(15.0, sea.salinity_psu, 0.0), abs=1e-6)
    assert built({"density_kg_m3": 1090.0}).salinity_psu == pytest.approx(45.0), "the nearest"


@pytest.mark.parametrize(("density", "salinity"), [(1000, 35), (1025, 0), (1030, 10), (1035, 35)])
def test_a_density_that_the_salinity_does_not_give_is_refused_with_both(density: float, salinity: float) -> None:
    pair = {"density_kg_m3": density, "salinity_psu": salinity}
    message = f"density_kg_m3 = {density} kg/m3: must be within 5 kg/m3 of "
    ends = {"surface": {"temperature_deg_c": 15.0, **pair}, "bottom": {"temperature_deg_c": 15.0, **pair}}
    level = {"depth_m": 0.0, "temperature_deg_c": 15.0, **pair}
    for values, where in (
        (pair, ""),
        ({**pair, "compressible": False}, ""),
        ({"profile": {"kind": "linear", **ends}}, "profile.surface."),
        ({"profile": {"kind": "table", "levels": [level]}}, "profile.levels[0]."),
    ):
        got = refusal(values, bottom_m=10.0)
        assert where + message in got and f"which salinity_psu = {salinity} psu gives at" in got


def test_a_cast_whose_density_contradicts_its_salinity_is_refused(tmp_path: Path) -> None:
    (tmp_path / "cast.csv").write_text(
        "depth_m,temperature_deg_c,salinity_psu,density_kg_m3\n0,15,35,1026\n10,14,35,1000\n"
    )
    got = refusal({"profile": {"kind": "table", "file": "cast.csv"}}, folder=tmp_path)
    assert "cast.csv': line 3: density_kg_m3 = 1000 kg/m3: must be within 5 kg/m3 of" in got


def test_rounded_densities_and_those_measured_in_place_agree() -> None:
    built({"density_kg_m3": 1000, "salinity_psu": 0, "surface_temperature_deg_c": 30, "bottom_temperature_deg_c": 30})
    built({"density_kg_m3": 1025, "salinity_psu": 35, "surface_temperature_deg_c": -2, "bottom_temperature_deg_c": -2})
    deep = {"depth_m": 4000.0, "temperature_deg_c": 2.0, "salinity_psu": 35.0}
    in_place = {**deep, "density_kg_m3": _core.sea_water_density_kg_m3(2.0, 35.0, 4.05e7)}
    profile = {"profile": {"kind": "table", "levels": [in_place]}}
    assert built({**profile, "compressible": False}, bottom_m=4000.0).density_kg_m3 > 1040
    assert "density_kg_m3 = 1046" in refusal(profile, bottom_m=4000.0)


def test_a_parameter_takes_the_density_with_it_unless_that_is_given() -> None:
    sim = Simulator(in_water())
    assert sim.parameters["water.density_kg_m3"] == _core.sea_water_density_kg_m3(15.0, 0.0)
    sim.parameters["water.salinity_psu"] = 35.0
    assert sim.world.water.density_kg_m3 == sim.parameters["water.density_kg_m3"] == SEA_KG_M3
    fresh = Simulator(in_water(density_kg_m3=1000))
    with pytest.raises(ScenarioError, match=r"^water\.density_kg_m3 = 1000 kg/m3: .* salinity_psu = 35 psu"):
        fresh.parameters["water.salinity_psu"] = 35.0
    assert fresh.world.water.salinity_psu == 0.0
    fresh.parameters.update({"water.salinity_psu": 35.0, "water.density_kg_m3": None})
    assert fresh.world.water.density_kg_m3 == SEA_KG_M3


def test_water_that_is_the_same_has_one_fingerprint() -> None:
    plain, sea = in_water(density_kg_m3=1000), in_water(salinity_psu=35)
    assert scenario_fingerprint(plain) == scenario_fingerprint(in_water(density_kg_m3=1000, salinity_psu=0))
    assert scenario_fingerprint(sea) == scenario_fingerprint(in_water(salinity_psu=35, density_kg_m3=SEA_KG_M3))
    assert len({scenario_fingerprint(each) for each in (plain, sea, in_water(), in_water(salinity_psu=34))}) == 4


WARM = [(13.0, 38.5), (25.1, 0.0), (29.0, 35.0), (40.0, 42.0), (-2.0, 0.0)]


@pytest.mark.parametrize(("temperature", "salinity"), WARM)
def test_a_simulator_starts_in_the_worlds_waters(temperature: float, salinity: float) -> None:
    ends = {"surface_temperature_deg_c": temperature, "bottom_temperature_deg_c": temperature}
    for bed_depth_m in (12.0, 18.762875):
        scenario = in_water(**ends, salinity_psu=salinity)
        terrain = scenario.terrain.model_copy(update={"bed_depth_m": bed_depth_m})
        sim = Simulator(scenario.model_copy(update={"terrain": terrain}))
        sim.advance(0.1)
        speed = _core.sound_speed_m_s(temperature, salinity, 5.0, sim.world.water.sound_speed_equation)
        assert sim.world.water.sound_speed_m_s(-5.0) == pytest.approx(speed, abs=1e-3)


def test_the_warm_scenario_is_flown_and_its_sonar_sees_the_bed_at_its_speed_of_sound() -> None:
    sim = Simulator("lagoon")
    assert sim.world.water.density_kg_m3 == _core.sea_water_density_kg_m3(29.0, 35.0)
    assert sim.world.water.sound_speed_m_s(-5.0) == pytest.approx(1543.5, abs=0.5)
    sim.rov.undock()
    sim.advance(1.0)
    assert np.isfinite(sim.rov.sonar.ping().ranges_m).any()
    assert load("lagoon").survey is not None
