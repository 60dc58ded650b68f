"""The along-swath outlier gate drops isolated soundings and keeps beds, steps and objects four beams wide."""

import numpy as np
import pytest

from uwsim import fly
from uwsim.flight.survey import fly_survey
from uwsim.mapping import OccupancyMap, ranging
from uwsim.missions import wait
from uwsim.scenario import Scenario, load
from uwsim.simulator.simulator import Simulator

MODEL = ranging.MODELS[1]
ANGLES = MODEL.angle_min_rad + MODEL.angle_increment_rad * np.arange(MODEL.beams)


def in_physics_mode() -> Scenario:
    """Return the pool with an em2040-07 at 300 kHz in physics mode."""
    scenario = load("pool")
    vehicle = scenario.vehicles[0]
    changes = {"mode": "physics", "model": "em2040-07", "frequency_hz": 300000}
    sonar = vehicle.sonar.model_validate({**dict(vehicle.sonar), **changes})
    return scenario.model_copy(update={"vehicles": (vehicle.model_copy(update={"sonar": sonar}),)})


def filtered(ranges_m: np.ndarray) -> np.ndarray:
    return ranging.reject_outliers(ranging.to_laser_scan(ranges_m.astype(np.float32), MODEL)).ranges


def plane(height_m: float, slope_rad: float) -> np.ndarray:
    """Return the ranges to a plane across the swath; beyond 90 m there is no echo."""
    ranges = height_m / np.maximum(np.cos(ANGLES - slope_rad), 1e-9)
    return np.where(ranges < 90.0, ranges, np.inf).astype(np.float32)


@pytest.mark.parametrize("height_m", [1.0, 8.0, 40.0])
@pytest.mark.parametrize("slope_rad", [0.0, 0.3, -0.6])
def test_a_plane_with_centimetres_of_noise_is_kept(height_m: float, slope_rad: float) -> None:
    incidence = np.abs(ANGLES - slope_rad)
    ranges = plane(height_m, slope_rad) + np.random.default_rng(1).normal(0.0, 0.02, MODEL.beams)
    steep = incidence > ranging.STEEPEST_RAD - 0.05
    kept = filtered(ranges)
    np.testing.assert_array_equal(kept[~steep], ranges.astype(np.float32)[~steep])


@pytest.mark.parametrize("beams", [1, 2, 3])
def test_what_few_beams_meet_alone_is_dropped_and_four_are_kept(beams: int) -> None:
    bed = plane(20.0, 0.0)
    for first in (0, 100, 256, MODEL.beams - 40):
        ranges = bed.copy()
        ranges[first : first + beams] = 6.0
        expected = bed.copy()
        expected[first : first + beams] = np.inf
        np.testing.assert_array_equal(filtered(ranges), expected)
        ranges[first : first + 4] = 6.0
        np.testing.assert_array_equal(filtered(ranges), ranges)


def test_both_sides_of_a_cliff_are_kept() -> None:
    ranges = np.where(np.arange(MODEL.beams) < 200, 10.0, 40.0)
    np.testing.assert_array_equal(filtered(ranges), ranges.astype(np.float32))


def test_random_false_ranges_are_dropped_and_echoes_are_not() -> None:
    rng = np.random.default_rng(2)
    dropped = lost = false_count = 0
    for _ in range(50):
        bed = plane(15.0, 0.1)
        false = (rng.uniform(size=MODEL.beams) < 0.03) & np.isfinite(bed)
        ranges = np.where(false, rng.uniform(1.0, 90.0, MODEL.beams), bed)
        kept = np.isfinite(filtered(ranges))
        far = false & (np.abs(ranges - bed) > 10.0)
        dropped, false_count = dropped + int((far & ~kept).sum()), false_count + int(far.sum())
        lost += int((~false & np.isfinite(bed) & ~kept).sum())
    assert dropped > 0.97 * false_count > 100
    assert lost == 0


def test_a_ping_without_echoes_stays_one() -> None:
    assert np.isinf(filtered(np.full(MODEL.beams, np.inf))).all()


@pytest.mark.parametrize(("mode", "by_default"), [("geometry", False), ("physics", True)])
def test_a_survey_filters_by_default_in_physics_mode_alone(mode: str, by_default: bool) -> None:
    scenario = load("pool")
    vehicle = scenario.vehicles[0]
    sonar = vehicle.sonar.model_validate({**dict(vehicle.sonar), "mode": mode})
    scenario = scenario.model_copy(update={"vehicles": (vehicle.model_copy(update={"sonar": sonar}),)})

    def flown(outlier_filter: bool | None) -> tuple[OccupancyMap, bool]:
        occupancy, record = fly_survey(Simulator(scenario, mission_time_s=4.0), outlier_filter=outlier_filter)
        return occupancy, record.outlier_filter

    occupancy, used = flown(None)
    explicit, _ = flown(by_default)
    assert used is by_default
    assert occupancy.to_bytes("ot") == explicit.to_bytes("ot")


def test_echoes_are_kept_up_to_their_own_uncertainty() -> None:
    ranges = np.array([5.0, 6.0, np.inf, 7.0])
    deviations = np.array([0.1, 0.1001, np.inf, 0.0])
    kept = ranging.reject_uncertain(ranges, deviations, 0.196)
    np.testing.assert_array_equal(kept, np.array([5.0, np.inf, np.inf, 7.0], np.float32))
    for wrong in (0.0, -1.0, float("nan")):
        with pytest.raises(ValueError, match=r"max_uncertainty_m = .* m: must be positive"):
            ranging.reject_uncertain(ranges, deviations, wrong)


def test_an_echo_is_at_least_as_uncertain_as_the_beam_is_wide() -> None:
    sim = Simulator(in_physics_mode())
    ping = sim.rov.sonar.ping()
    found = ping.valid
    width_rad = np.radians(0.933)
    assert found.sum() > 50
    deviation_m = ranging.place_deviation_m(ping)
    assert deviation_m is not None
    across_m = ping.ranges_m[found] * width_rad / np.sqrt(12)
    np.testing.assert_allclose(deviation_m[found], np.hypot(ping.deviation_m[found], across_m), rtol=1e-5)
    assert np.isinf(deviation_m[~found]).all()
    assert ranging.place_deviation_m(Simulator("pool").rov.sonar.ping()) is None


def test_a_limit_of_what_is_not_known_or_not_filtered_is_refused() -> None:
    survey = load("pool").survey
    assert survey is not None
    limited = load("pool").model_copy(update={"survey": survey.model_copy(update={"max_uncertainty_m": 0.1})})
    with pytest.raises(ValueError, match=r"survey.max_uncertainty_m = 0.1 m: needs a sonar with `mode: physics`"):
        fly_survey(Simulator(limited))
    with pytest.raises(ValueError, match=r"survey.max_uncertainty_m = 0.1 m: needs a sonar with `mode: physics`"):
        fly(idle, limited, map=True)
    with pytest.raises(ValueError, match="has no effect if outlier_filter is false"):
        survey.model_validate({**dict(survey), "max_uncertainty_m": 0.1, "outlier_filter": False})


def idle(vehicle):
    yield wait(1.0)


def test_the_scenario_and_the_caller_may_choose() -> None:
    scenario = load("pool")
    assert scenario.survey is not None
    scenario = scenario.model_copy(update={"survey": scenario.survey.model_copy(update={"outlier_filter": True})})
    assert fly_survey(Simulator(scenario, mission_time_s=1.0))[1].outlier_filter
    assert not fly_survey(Simulator(scenario, mission_time_s=1.0), outlier_filter=False)[1].outlier_filter
