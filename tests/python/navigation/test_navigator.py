"""The navigation filter compared with the truth, and inputs that must not affect it."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from uwsim import Simulator
from uwsim.navigation.estimation import Navigator, Start
from uwsim.navigation.estimation.aids import AIDS, Surroundings
from uwsim.scenario import Scenario, load, load_vehicle
from uwsim.scenario.read.assets import assets_folder
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.sensor import SensorMount

WALK = np.random.default_rng(4).uniform(-0.4, 0.4, (40, 6)) * [1.0, 1.0, 0.3, 0.1, 0.1, 1.0]


def flown(sim: Simulator, seconds: float, look: float | None = None) -> Simulator:
    """Fly for a time, changing the effort every 3 s, and read the estimate at intervals."""
    for k in range(round(seconds / 3.0)):
        sim.rov.set_effort(*WALK[(k + round(sim.time_s / 3.0)) % len(WALK)])
        for _ in range(round(3.0 / (look or 3.0))):
            sim.advance(look or 3.0)
            if look:
                _ = sim.rov.estimate.pose
    return sim


def undocked(scenario: str = "lake", seed: int = 5) -> Simulator:
    sim = Simulator(scenario, seed=seed)
    sim.rov.undock()
    return sim


def errors(sim: Simulator, estimate: Navigator | None = None) -> np.ndarray:
    """Return the errors of position, velocity (world) and attitude (body), (9,)."""
    estimate, true = estimate or sim.rov.estimate, sim.rov
    turn, true_turn = estimate.pose.world_from_body[:3, :3], true.pose.world_from_body[:3, :3]
    velocity = true_turn @ true.velocity.linear_body_m_s - turn @ estimate.velocity.linear_body_m_s
    position = true.pose.position_world_m - estimate.pose.position_world_m
    return np.concatenate([position, velocity, Rotation.from_matrix(turn.T @ true_turn).as_rotvec()])


def test_errors_are_within_what_the_filter_says() -> None:
    sim = undocked()
    _ = sim.rov.estimate
    for _ in range(5):
        flown(sim, 15.0)
        error, p = errors(sim), sim.rov.estimate.covariance[:9, :9]
        assert error @ np.linalg.solve(p, error) < 33.7  # chi-squared, 9 degrees of freedom: p = 1e-4
        assert np.linalg.eigvalsh(p).min() > 0
    assert np.abs(errors(sim)[:3]).max() < 0.5


def test_the_estimate_does_not_depend_on_how_often_it_is_looked_at_or_that_it_is_saved() -> None:
    seldom, often, never = undocked(), undocked(), undocked()
    _ = seldom.rov.estimate, often.rov.estimate
    flown(often, 15.0, look=0.05)
    flown(never, 15.0)
    state, saved = flown(seldom, 15.0).save_state(), Simulator("lake", seed=5)
    saved.restore_state(state)
    for sim, look in ((seldom, None), (saved, None), (often, 0.5)):
        flown(sim, 9.0, look)
    for sim in (often, saved):
        assert (seldom.rov.estimate.covariance == sim.rov.estimate.covariance).all()
        assert (seldom.rov.estimate.pose.world_from_body == sim.rov.estimate.pose.world_from_body).all()
        assert seldom.rov.estimate.counts == sim.rov.estimate.counts
    flown(never, 9.0)
    assert (often.rov.pose.world_from_body == never.rov.pose.world_from_body).all(), "looking changes nothing else"
    assert often.rov.sensors["usbl"].read().range_m == never.rov.sensors["usbl"].read().range_m


def test_late_fixes_count_for_when_they_were_measured() -> None:
    """If late fixes counted as current, a moving vehicle would be estimated behind its true position."""
    sim = undocked()
    sim.parameters.update({"rov.sensors.usbl.latency_s": 2.0, "rov.sensors.usbl.channels.bearing.std": 1e-3})
    sim.parameters["rov.sensors.dvl.on"] = False
    sim.rov.set_effort(surge=0.8)
    sim.advance(5.0)
    estimate = Navigator(sim.rov)
    sim.advance(40.0)
    speed = np.linalg.norm(sim.rov.velocity.linear_body_m_s)
    assert speed > 0.5 and np.linalg.norm(errors(sim, estimate)[:2]) < 0.35 * 2.0 * speed
    assert estimate.too_late == 0


def test_a_fix_that_is_far_off_or_from_a_ray_above_the_water_is_rejected() -> None:
    sim = undocked()
    before = flown(sim, 9.0, look=0.5).rov.estimate.counts["usbl"]
    around = Surroundings(np.zeros(3), 9.8, 1000.0, 0.0, 0.1, 0.0, 0.0, (1480.0, 1480.0))
    readings = np.zeros((2, 9))
    readings[:, :4] = [[20.0, 0.0, -5.0, 20.6], [20.0, 0.0, 60.0, 63.2]]
    samples = SimpleNamespace(valid=np.array([True, True]), readings=readings)
    assert AIDS["usbl"].readings(sim.rov.sensors["usbl"], samples, around)[0].tolist() == [True, False]
    sim.parameters["rov.sensors.usbl.channels.range.turn_on_std"] = 500.0
    flown(sim, 3.0)
    after = sim.rov.estimate.counts["usbl"]
    assert after[1] > before[1] and np.linalg.norm(errors(sim)[:3]) < 1.0


def test_fixes_by_the_bed_do_not_move_the_estimate() -> None:
    """350 m from the station in water 60 m deep, the USBL locks onto the echo by the bed."""
    sim = Simulator(
        {
            "name": "bay", "seed": 1, "description": "a bay, its station far away", "water": {"density_kg_m3": 1026},
            "terrain": {"source": "noise", "size_m": [1000, 1000], "spacing_m": 10, "bed_depth_m": 60},
            "station": {"position_m": [380.0, 0.0, 0.0], "dock_m": [0.0, 0.0, -2.0]},
            "vehicles": [{"name": "rov", "model": "remus100", "start": {"position_m": [0.0, 0.0, -3.0]}}],
        }
    )  # fmt: skip
    _ = sim.rov.estimate
    sim.rov.set_effort(surge=0.6)
    sim.advance(60.0)
    fix = sim.rov.sensors["usbl"].read().position_m
    assert fix[2] < -50.0, "no echo by the bed: this tests nothing"
    accepted, rejected = sim.rov.estimate.counts["usbl"]
    assert accepted == 0 and rejected > 60, "the filter, without bottom lock, is left to its own drift"
    assert np.linalg.norm(errors(sim)[:3]) < 3.0 * np.linalg.norm(sim.rov.estimate.position_std_m)


def test_it_survives_an_imu_that_falls_silent() -> None:
    sim = undocked()
    flown(sim, 15.0, look=0.5)
    std = sim.rov.estimate.position_std_m
    sim.parameters["rov.sensors.imu.on"] = False
    sim.advance(6.0)
    assert sim.time_s - sim.rov.estimate.time_s <= 0.5
    sim.parameters["rov.sensors.imu.on"] = True
    flown(sim, 15.0)
    assert np.linalg.norm(errors(sim)[:3]) < 0.5 + 5 * np.linalg.norm(std)


def test_a_vehicle_with_imu_and_depth_alone_counts_on_from_its_start() -> None:
    sim = Simulator("paper")
    sim.rov.undock()
    with pytest.raises(ValueError, match="no USBL"):
        Navigator(sim.rov)
    start = Start(tuple(sim.rov.pose.position_world_m), 0.01)
    estimate = Navigator(sim.rov, start)
    flown(sim, 12.0)
    assert np.abs(errors(sim, estimate)).max() < 0.5


def test_moving_the_vehicle_by_hand_starts_it_anew() -> None:
    sim = undocked()
    flown(sim, 6.0, look=0.5)
    sim.rov.place((-30.0, -40.0, -20.0))
    sim.advance(1.0)
    assert np.linalg.norm(errors(sim)[:3]) < 0.5
    sim.reset()
    assert np.linalg.norm(errors(sim)[:3]) < 0.5


WAVES = {"kind": "airy", "amplitude_m": 0.25, "period_s": 5.0}


def lagoon(surface: dict[str, object], sensors: dict[str, object] | None = None) -> Simulator:
    """Return a simulator of the lagoon with this surface, its vehicle free and neutral at 3 m."""
    scenario = load("lagoon")
    plain = {key: getattr(scenario, key) for key in type(scenario).model_fields}
    plain["water"] = {**scenario.water.model_dump(), "surface": surface}
    start = {"position_m": [0.0, 0.0, -3.0]}
    vehicle = {"name": "rov", "model": "bluerov2_heavy", "trim": {"net_buoyancy_n": 0.0}, "start": start}
    plain["vehicles"] = [vehicle]
    return Simulator(Scenario.model_validate(plain, context={"folder": assets_folder() / "scenarios"}), seed=1)


@pytest.mark.parametrize("amplitude_m, period_s", [(0.25, 10.0), (0.1, 3.0)])
def test_the_pressure_of_waves_does_not_move_the_estimate(amplitude_m: float, period_s: float) -> None:
    sim = lagoon({"kind": "airy", "amplitude_m": amplitude_m, "period_s": period_s})
    _ = sim.rov.estimate
    for _ in range(60):
        sim.advance(1.0)
        error = errors(sim)
        assert np.linalg.norm(error[3:6]) < 0.1 and np.linalg.norm(error[:3]) < 0.3, sim.time_s
    assert all(rejected == 0 for _, rejected in sim.rov.estimate.counts.values())


def test_a_sea_that_rises_beyond_what_was_expected_is_learned() -> None:
    """A filter that expects still water meets waves of 0.5 m height: its gates recover, and it goes on."""
    sim = lagoon(WAVES)
    start = Start(tuple(sim.rov.pose.position_world_m), 0.1, (0.0, 0.0, 0.0), 0.05)
    density_kg_m3 = float(sim.world.water.density_at_kg_m3(0.0))
    estimate = Navigator(sim.rov, start, density_kg_m3=density_kg_m3, wave_std_m=0.0)
    sim.advance(15.0)
    rejected = estimate.counts["depth"][1]
    for _ in range(45):
        sim.advance(1.0)
        error = errors(sim, estimate)
        assert np.linalg.norm(error[3:6]) < 0.1 and np.linalg.norm(error[:3]) < 0.3, sim.time_s
    assert estimate.counts["depth"][1] == rejected


def test_still_water_is_as_well_known_as_before_and_a_range_no_surer_than_its_rounding_permits() -> None:
    sim, rounded = lagoon({"kind": "still"}), lagoon({"kind": "still"})
    rounded.parameters["rov.sensors.usbl.channels.range.quantum"] = 1.0
    estimate, _ = rounded.rov.estimate, sim.rov.estimate
    for one in (sim, rounded):
        one.advance(60.0)
    assert abs(errors(sim)[5]) < 0.004 and abs(errors(sim)[2]) < 0.05
    line = rounded.rov.pose.position_world_m - np.asarray(rounded.scenario.station.position_m)
    line /= np.linalg.norm(line)
    error, std = line @ errors(rounded)[:3], float(np.sqrt(line @ estimate.covariance[:3, :3] @ line))
    assert abs(error) < 3.0 * std


def test_a_docked_vehicle_stays_where_the_dock_holds_it() -> None:
    sim = Simulator("paper", seed=3)
    estimate = sim.rov.estimate
    sim.advance(60.0)
    assert (estimate.position_std_m < 0.11).all() and np.abs(errors(sim)).max() < 0.01
    state = sim.save_state()
    other = Simulator("paper", seed=3)
    other.restore_state(state)
    for one in (sim, other):
        one.advance(30.0)
    assert (sim.rov.estimate.covariance == other.rov.estimate.covariance).all()


def test_a_dry_gauge_is_not_a_depth() -> None:
    """The vehicle falls from its dock, 4 m above the water: 0 m of water over the gauge is not a depth of 0 m."""
    sim = Simulator("paper", seed=3)
    estimate = sim.rov.estimate
    sim.advance(20.0)
    sim.rov.release()
    for _ in range(40):
        sim.advance(0.1)
        error = errors(sim)
        assert np.linalg.norm(error[3:6]) < 0.15 and np.linalg.norm(error[:3]) < 0.15, sim.time_s
        std = np.sqrt(np.diagonal(estimate.covariance)[:6])
        assert (np.abs(error[:6]) < 5.0 * std + 0.05).all(), sim.time_s
    assert estimate.counts["depth"][1] == 0


def bay(vehicle: dict[str, Any]) -> Scenario:
    terrain = {"source": "noise", "size_m": [400, 400], "spacing_m": 10, "bed_depth_m": 60}
    return validated(Scenario, {"name": "bay", "terrain": terrain, "vehicles": [vehicle]})


GPS = {
    "kind": "gps", "position_m": [0.1, 0.0, 0.5], "rate_hz": 5,
    "channels": {"horizontal": {"std": 0.3, "bias_std": 0.5, "bias_time_s": 300}, "velocity": {"std": 0.05}},
}  # fmt: skip


def test_satellites_correct_a_vehicle_that_surfaces() -> None:
    rov = load_vehicle("rov")
    model = rov.model_copy(update={"sensors": rov.sensors | {"gps": validated(SensorMount, GPS)}})
    vehicle = {"name": "rov", "model": model, "start": {"position_m": [0, 0, -8]}}
    sim = Simulator(bay(vehicle), seed=4)
    sensors = {name: each for name, each in sim.rov.sensors.items() if each.kind in ("imu", "depth", "compass", "gps")}
    estimate = Navigator(SimpleNamespace(name="rov", sensors=sensors), Start((0.0, 0.0, -8.0), 0.1))
    for k in range(40):
        sim.rov.set_effort(surge=0.5, yaw=0.3 * (-1) ** k)
        sim.advance(3.0)
    dived = errors(sim, estimate), estimate.position_std_m
    sim.rov.set_effort(heave=0.6)
    sim.advance(60.0)
    found = errors(sim, estimate), estimate.position_std_m
    for error, std_m in (dived, found):
        assert (np.abs(error[:3]) < 4.0 * std_m).all()
    assert dived[1][:2].min() > 3.0 and found[1][:2].max() < 0.6  # its bias remains
    assert np.abs(found[0][3:5]).max() < 0.1 and estimate.counts["gps"][0] > 300


def test_a_boat_knows_its_place_by_satellites() -> None:
    sim = Simulator(bay({"name": "boat", "model": "otter", "start": {"position_m": [0, 0, 0]}}), seed=3)
    beside = Navigator(sim.rov)  # it begins by its first fixes
    for k in range(30):
        sim.rov.set_effort(surge=0.6, yaw=0.2 * (-1) ** k)
        sim.advance(4.0)
        if k > 3:
            for estimate in (sim.rov.estimate, beside):
                assert np.abs(errors(sim, estimate)[:6]).max() < 0.12
    saved = sim.rov.estimate.pose.position_world_m, sim.save_state()
    sim.advance(1.0)
    sim.restore_state(saved[1])
    np.testing.assert_array_equal(sim.rov.estimate.pose.position_world_m, saved[0])


LENS = [{"depth_m": z, "temperature_deg_c": 10, "salinity_psu": s} for z, s in ((0, 5), (10, 5), (12, 35))]
LOW, HIGH = ({"tide": {"constituents": [{"constituent": "M2", "amplitude_m": 1.5, "phase_deg": k}]}} for k in (0, 180))


@pytest.mark.parametrize(
    "water, depth_m", [(LOW, 10.0), (HIGH, 10.0), ({"profile": {"kind": "table", "levels": LENS}}, 50.0), ({}, 930.0)]
)
def test_a_depth_gauge_under_unknown_water_does_not_move_the_estimate(water: dict[str, Any], depth_m: float) -> None:
    """Law: the estimate errs by what it admits, and the gates do not shut the USBL out."""
    vehicle = {"name": "rov", "model": "rov", "start": {"position_m": [0, 0, -depth_m]}}
    terrain = {"source": "noise", "size_m": [400, 400], "spacing_m": 10, "bed_depth_m": depth_m + 20}
    station = {"position_m": [30, 20, -5]}
    plain = {"name": "bay", "terrain": terrain, "water": water, "station": station, "vehicles": [vehicle]}
    sim = Simulator(validated(Scenario, plain), seed=1)
    estimate = sim.rov.estimate
    for _ in range(3):
        flown(sim, 21.0)
        error, covariance = errors(sim)[:3], estimate.covariance[:3, :3]
        assert error @ np.linalg.solve(covariance, error) < 21.1  # chi-squared, 3 degrees of freedom: p = 1e-4
        assert abs(error[2]) < 0.3
    assert estimate.counts["usbl"][1] == 0
    (level_m,) = sim.world.water.surface_height_m(np.zeros((1, 2)), sim.time_s)
    assert abs(estimate.surface_m[0] - level_m) < 4.0 * estimate.surface_m[1]
    state, other = sim.save_state(), Simulator(sim.scenario, seed=1)
    other.restore_state(state)
    assert other.rov.estimate.surface_m == estimate.surface_m


def test_a_gauge_set_to_the_density_of_the_sea_measures_the_depth_of_a_lake() -> None:
    """It shows 2.5 % too little, as its data sheet states."""
    sim = undocked()
    sim.rov.place((-30.0, -40.0, -12.0))
    sim.parameters["rov.sensors.depth.density_kg_m3"] = 1025.0
    flown(sim, 30.0, look=3.0)
    assert sim.rov.sensors["depth"].read() < -0.98 * sim.rov.pose.position_world_m[2]
    assert abs(errors(sim)[2]) < 0.1 and sim.rov.estimate.counts["depth"][1] == 0
