"""The navigation suite: who flies, and laws of its places, a few short flights each."""

from dataclasses import replace

import numpy as np
import pytest

from uwsim.evidence.validate.navigator import by_place as navigation
from uwsim.evidence.validate.navigator.places import PLACES, WITH_DVL, WITH_GAUGE
from uwsim.navigation.estimation.aids import AIDS
from uwsim.navigation.estimation.budget import NOISE, position_budget
from uwsim.scenario.read.assets import assets_folder
from uwsim.scenario.spec.vehicle import load_vehicle

MOUNTED, SOLD = "DVL and USBL as mounted", "the same, an IMU of 1 %"


def test_every_vehicle_with_a_dvl_is_flown_and_in_unknown_water_every_one_with_a_gauge() -> None:
    models = {path.stem: load_vehicle(path.stem) for path in (assets_folder() / "vehicles").glob("*.yaml")}
    kinds = {name: {sensor.kind for sensor in model.sensors.values()} for name, model in models.items()}
    steady = {name for name, model in models.items() if model.arm is None}  # an arm shakes its vehicle
    assert {name for name, found in kinds.items() if "dvl" in found and name in steady} == set(WITH_DVL)
    with_gauge = {name for name, found in kinds.items() if found & {"depth", "pressure"} and "imu" in found}
    assert with_gauge == set(WITH_GAUGE)


@pytest.mark.parametrize("name", [name for name in PLACES if "Airy" not in name])
def test_in_each_place_the_errors_match_what_the_filter_expects(name: str) -> None:
    place = replace(PLACES[name], vehicles=WITH_DVL[:2])
    flown = navigation.fly_in(place, 8 if place.lost else 2)  # where errors grow, more chance is in a flight
    missed = [check for check in navigation.checks(name, place, flown) if not check.passed]
    assert not missed


def test_a_filter_that_does_not_know_how_a_dvl_is_mounted_is_too_sure(monkeypatch: pytest.MonkeyPatch) -> None:
    place = replace(PLACES[MOUNTED], vehicles=("rov",))
    bare = replace(place, settings={}).simulators()[0].rov.sensors["dvl"]
    honest = [flight[-1].nees[0] for flight in navigation.fly_in(place, 3)]
    known = AIDS["dvl"]
    unaware = known._replace(
        add_to=lambda filter_, _, around: known.add_to(filter_, bare, around), terms=lambda *_: {"beams": 4}
    )
    monkeypatch.setitem(AIDS, "dvl", unaware)
    sure = [flight[-1].nees[0] for flight in navigation.fly_in(place, 3)]
    assert np.mean(sure) > 1.5 * np.mean(honest)


def test_the_parts_of_the_position_add_up_and_those_of_independent_errors_are_their_own() -> None:
    weights = np.array([[1.0, 0.5, 0.0], [0.0, 2.0, 0.3]])
    variances = np.array([0.4, 0.1])
    covariance = np.diag([1.0, 2.0, 3.0, *variances])
    covariance[3:, :3] = variances[:, None] * weights
    covariance[:3, 3:] = covariance[3:, :3].T
    covariance[:3, :3] += weights.T @ np.diag(variances) @ weights
    budget = position_budget(covariance, {"a": slice(3, 4), "b": slice(4, 5)})
    np.testing.assert_allclose(budget["a"] ** 2, variances[0] * weights[0] ** 2, atol=1e-12)
    np.testing.assert_allclose(budget["b"] ** 2, variances[1] * weights[1] ** 2, atol=1e-12)
    np.testing.assert_allclose(budget[NOISE] ** 2, [1.0, 2.0, 3.0])


def test_a_vehicle_states_which_metre_comes_from_what() -> None:
    settings = {**PLACES[MOUNTED].settings, **PLACES[SOLD].settings}
    with replace(PLACES[MOUNTED], settings=settings, vehicles=("rov",)).simulators()[0] as sim:
        estimate = sim.rov.estimate
        sim.rov.set_effort(surge=0.4, yaw=0.1)
        sim.advance(10.0)
        budget = estimate.budget
        whole = np.sqrt(sum(np.square(std_m) for std_m in budget.values()))
        np.testing.assert_allclose(whole, estimate.position_std_m, rtol=1e-9)
        terms = "dvl.scale dvl.misalignment usbl.bearing depth.tide compass.hard_iron imu.gyroscope_scale"
        assert {*terms.split(), "imu.accelerometer_scale", NOISE} <= set(budget)
        assert "imu.gyroscope_by_force" not in budget
        assert budget["depth.bias"][2] > 3.0 * budget["depth.bias"][0]
