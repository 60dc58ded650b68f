"""The validation of the navigation filter, with few flights; `uwsim validate estimation` runs 50."""

import numpy as np

from uwsim import Simulator
from uwsim.evidence.validate import consistency, estimation
from uwsim.evidence.validate.after_contact import contact_checks
from uwsim.evidence.validate.turning_flights import turning_checks
from uwsim.evidence.validate.water_flights import VEHICLES as WITH_GAUGE
from uwsim.evidence.validate.water_flights import water_checks
from uwsim.evidence.validate.wave_flights import VEHICLES, wave_checks
from uwsim.scenario.read.assets import assets_folder
from uwsim.scenario.spec.vehicle import load_vehicle


def test_the_filter_is_as_sure_of_itself_as_it_may_be(monkeypatch) -> None:
    monkeypatch.setattr(estimation, "LEGS", 9)
    monkeypatch.setattr(estimation, "DROP_OUT_AFTER_S", 30.0)
    monkeypatch.setattr("uwsim.evidence.validate.estimation.turning_checks", lambda seeds: [])
    monkeypatch.setattr("uwsim.evidence.validate.estimation.wave_checks", lambda seeds: [])
    monkeypatch.setattr("uwsim.evidence.validate.estimation.water_checks", lambda seeds: [])
    checks = estimation.run(seeds=5)
    assert [check.name for check in checks if not check.passed] == []


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


def test_after_contacts_the_filter_errs_by_no_more_than_it_says() -> None:
    assert [check for check in contact_checks(Simulator("lake"), seeds=4) if not check.passed] == []


def test_a_vehicle_that_rolls_pitches_and_tumbles_knows_where_it_is() -> None:
    assert [check for check in turning_checks(seeds=8) if not check.passed] == []


def test_waves_do_not_move_the_estimate_and_every_vehicle_with_a_dvl_is_flown_in_them() -> None:
    """Law: below 0.1 m/s and 0.3 m in Airy waves of 0.1 and 0.25 m and in a sea of 0.5 m; NEES within its bounds."""
    models = {path.stem: load_vehicle(path.stem) for path in (assets_folder() / "vehicles").glob("*.yaml")}
    models = {name: model for name, model in models.items() if model.arm is None}  # whose motion an arm shakes
    with_dvl = {name for name, model in models.items() if "dvl" in {s.kind for s in model.sensors.values()}}
    assert with_dvl == set(VEHICLES)
    assert [check for check in wave_checks(seeds=12) if not check.passed] == []


def test_unknown_water_does_not_make_any_vehicle_with_a_gauge_sure_of_a_wrong_depth() -> None:
    """Law: NEES within its bounds in tides of 1.5 and 4 m, below a lens, and 985 m deep, and no fix is shut out."""
    models = {path.stem: load_vehicle(path.stem) for path in (assets_folder() / "vehicles").glob("*.yaml")}
    kinds = {name: {sensor.kind for sensor in model.sensors.values()} for name, model in models.items()}
    assert {name for name, found in kinds.items() if found & {"depth", "pressure"} and "imu" in found} == set(
        WITH_GAUGE
    )
    assert [check for check in water_checks(seeds=len(WITH_GAUGE)) if not check.passed] == []
