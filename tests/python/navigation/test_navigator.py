"""The navigation filter compared with the truth, and inputs that must not affect it."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from uwsim import Simulator
from uwsim.navigation.estimation import Navigator, Start

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


def test_the_estimate_does_not_depend_on_how_often_it_is_looked_at() -> None:
    seldom, often = undocked(), undocked()
    _ = seldom.rov.estimate, often.rov.estimate
    flown(seldom, 30.0)
    flown(often, 30.0, look=0.05)
    assert (seldom.rov.estimate.covariance == often.rov.estimate.covariance).all()
    assert (seldom.rov.estimate.pose.world_from_body == often.rov.estimate.pose.world_from_body).all()


def test_a_saved_simulator_continues_with_the_same_estimate() -> None:
    first = undocked()
    _ = first.rov.estimate
    state = flown(first, 15.2).save_state()
    second = Simulator("lake", seed=5)
    second.restore_state(state)
    for sim in (first, second):
        flown(sim, 9.0)
    assert (first.rov.estimate.covariance == second.rov.estimate.covariance).all()
    assert first.rov.estimate.counts == second.rov.estimate.counts


def test_looking_at_the_estimate_changes_nothing_else() -> None:
    watched, alone = flown(undocked(), 9.0, look=0.5), flown(undocked(), 9.0)
    assert (watched.rov.pose.world_from_body == alone.rov.pose.world_from_body).all()
    assert watched.rov.sensors["usbl"].read().range_m == alone.rov.sensors["usbl"].read().range_m


def test_late_fixes_count_for_when_they_were_measured() -> None:
    """If late fixes counted as current, a moving vehicle would be estimated behind its true position."""
    sim = undocked()
    sim.parameters.update({"rov.sensors.usbl.latency_s": 2.0, "rov.sensors.usbl.channels.bearing.std": 1e-3})
    sim.parameters["rov.sensors.dvl.on"] = False
    sim.rov.set_effort(surge=0.8)
    sim.advance(5.0)
    estimate = Navigator(sim.rov, station_world_m=sim.scenario.station.position_m)
    sim.advance(40.0)
    speed = np.linalg.norm(sim.rov.velocity.linear_body_m_s)
    assert speed > 0.5 and np.linalg.norm(errors(sim, estimate)[:2]) < 0.35 * 2.0 * speed
    assert estimate.too_late == 0


def test_a_fix_that_is_far_off_is_rejected() -> None:
    sim = undocked()
    before = flown(sim, 9.0, look=0.5).rov.estimate.counts["usbl"]
    sim.parameters["rov.sensors.usbl.channels.range.turn_on_std"] = 500.0
    flown(sim, 3.0)
    after = sim.rov.estimate.counts["usbl"]
    assert after[1] > before[1] and np.linalg.norm(errors(sim)[:3]) < 1.0


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
