"""The validation of the navigation filter, whose flights tools/docs makes: its statistics, and which vehicles fly."""

import numpy as np

from uwsim import Simulator
from uwsim.evidence.validate import consistency, estimation
from uwsim.evidence.validate.water_flights import VEHICLES as WITH_GAUGE
from uwsim.evidence.validate.wave_flights import VEHICLES as IN_WAVES
from uwsim.scenario.read.assets import assets_folder
from uwsim.scenario.spec.vehicle import load_vehicle


def test_a_filter_that_is_too_sure_of_itself_fails() -> None:
    honest = np.random.default_rng(0).chisquare(3, (20, 12, 3))
    nees = np.concatenate([honest.sum(axis=2, keepdims=True), honest], axis=2)
    assert all(check.passed for check in consistency.consistency_checks(nees))
    assert not any(check.passed for check in consistency.consistency_checks(2.0 * nees))
    assert not any(check.passed for check in consistency.consistency_checks(0.5 * nees))


def test_the_closed_form_grows_with_the_cube_of_time_at_last() -> None:
    sim = Simulator("lake")
    navigator, _ = consistency.start_navigation(sim, 0)
    early, late = (np.trace(estimation.closed_form(sim, navigator, t)) for t in (500.0, 1000.0))
    assert 2.0**6 < late / early < 2.0**7  # a gyroscope's bias grows as t^3, its drift as t^3.5


def test_every_vehicle_with_a_dvl_is_flown_in_waves_and_every_one_with_a_gauge_in_unknown_water() -> None:
    models = {path.stem: load_vehicle(path.stem) for path in (assets_folder() / "vehicles").glob("*.yaml")}
    kinds = {name: {sensor.kind for sensor in model.sensors.values()} for name, model in models.items()}
    steady = {name for name, model in models.items() if model.arm is None}  # an arm shakes its vehicle
    assert {name for name, found in kinds.items() if "dvl" in found and name in steady} == set(IN_WAVES)
    with_gauge = {name for name, found in kinds.items() if found & {"depth", "pressure"} and "imu" in found}
    assert with_gauge == set(WITH_GAUGE)
