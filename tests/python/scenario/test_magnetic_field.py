"""The World Magnetic Model in compasses: published test values, another model, and a compass that points by it."""

import math
from datetime import datetime
from typing import Any

import numpy as np
import pytest

from uwsim import ScenarioError, Simulator
from uwsim.navigation.estimation.aids import north_rad
from uwsim.scenario import Scenario, load
from uwsim.scenario.build.earth import compass_field
from uwsim.scenario.build.equipment import sensor_spec
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.settings import Earth

pytest.importorskip("pygeomag", reason="needs pygeomag")


def earth(latitude_deg: float, longitude_deg: float, year: float) -> Earth:
    return Earth(latitude_deg=latitude_deg, longitude_deg=longitude_deg, magnetic_year=year)


@pytest.mark.parametrize(("latitude", "longitude", "declination_deg", "horizontal_ut"), [
    (80, 0, 1.28, 6.5232), (0, 120, -0.16, 39.6779), (-80, -120, 68.78, 16.8981),
])  # fmt: skip
def test_the_published_test_values_of_wmm_2025_are_met(latitude, longitude, declination_deg, horizontal_ut) -> None:
    found = compass_field(earth(latitude, longitude, 2025.0))
    level_ut = found["field_ut"][0] * math.cos(math.radians(found["inclination_deg"][0]))
    assert found["declination_deg"][0] == pytest.approx(declination_deg, abs=0.006)
    assert level_ut == pytest.approx(horizontal_ut, abs=1e-3)


@pytest.mark.parametrize("year", [2021, 2026, 2029])
@pytest.mark.parametrize(("latitude", "longitude"), [(43.1, 5.9), (-33.9, 18.4), (60.4, 5.3), (36.8, -121.9)])
def test_igrf_agrees(latitude: float, longitude: float, year: int) -> None:
    igrf = pytest.importorskip("ppigrf", reason="needs ppigrf").igrf
    east, north, up = (float(np.squeeze(each)) for each in igrf(longitude, latitude, 0.0, datetime(year, 1, 1)))
    found = compass_field(earth(latitude, longitude, float(year)))
    assert found["declination_deg"][0] == pytest.approx(math.degrees(math.atan2(east, north)), abs=0.2)
    assert found["inclination_deg"][0] == pytest.approx(math.degrees(math.atan2(-up, math.hypot(east, north))), abs=0.2)
    assert found["field_ut"][0] == pytest.approx(1e-3 * math.hypot(east, north, up), rel=0.003)


def scenario(place: dict[str, Any] | None) -> Scenario:
    return validated(Scenario, {**load("lagoon").given(), "earth": place})


def test_a_compass_points_to_magnetic_north_and_its_own_figures_prevail() -> None:
    place = {"latitude_deg": 36.8, "longitude_deg": -121.9, "magnetic_year": 2026.5}
    by_place, without = Simulator(scenario(place)), Simulator(scenario(None))
    name = next(name for name, sensor in by_place.rov.sensors.items() if sensor.kind == "compass")
    declination_rad = math.radians(compass_field(Earth(**place))["declination_deg"][0])
    assert declination_rad == pytest.approx(math.radians(12.5), abs=math.radians(0.5))
    assert north_rad(by_place.rov.sensors[name]) == pytest.approx(math.pi / 2 - declination_rad)
    assert north_rad(without.rov.sensors[name]) == pytest.approx(math.pi / 2)
    for sim in (by_place, without):
        sim.step(200)
    turned = math.remainder(without.rov.sensors[name].read() - by_place.rov.sensors[name].read(), math.tau)
    mount = by_place.scenario.vehicles[0].model.sensors[name]
    own = mount.model_copy(update={"parameters": {**mount.parameters, "declination_deg": (3.0,)}})
    assert sensor_spec(name, own, Earth(**place)).parameters["declination_deg"] == [3.0]
    assert turned == pytest.approx(declination_rad, abs=math.radians(1.5))  # the vehicle's own iron turns it, too


def test_places_and_years_without_a_field_for_compasses_are_refused() -> None:
    with pytest.raises(ScenarioError, match=r"earth\.magnetic_year: the field's horizontal part is .* uT here"):
        compass_field(earth(86.0, 139.0, 2026.0))  # beside the magnetic pole
    with pytest.raises(ScenarioError, match=r"magnetic_year = 2031 yr: must be in \[2020, 2030\]"):
        scenario({"latitude_deg": 43.1, "longitude_deg": 5.9, "magnetic_year": 2031})
    assert compass_field(None) == compass_field(Earth(latitude_deg=86.0, longitude_deg=139.0)) == {}
