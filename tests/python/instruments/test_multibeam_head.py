"""The multibeam head: its elevation, its ping rate, and batches of pings."""

import numpy as np
import pytest

from uwsim import Simulator

ARRAYS = ("ranges_m", "points_sonar_m", "incidence_rad", "intensity_db", "labels", "valid")


@pytest.fixture
def pool() -> Simulator:
    return Simulator("pool", sonar_model=4)


def poses_in(pool: Simulator, count: int) -> np.ndarray:
    random = np.random.default_rng(3)
    poses = np.tile(pool.rov.pose.world_from_body, (count, 1, 1))
    turns = random.uniform(-np.pi, np.pi, count)
    poses[:, 0, 0] = poses[:, 1, 1] = np.cos(turns)
    poses[:, 1, 0] = np.sin(turns)
    poses[:, 0, 1] = -np.sin(turns)
    poses[:, :3, 3] = random.uniform([-3, -3, -4], [3, 3, -1], (count, 3))
    return poses


def test_the_head_starts_at_the_scenarios_tilt_and_turns_at_five_degrees_per_second(pool: Simulator) -> None:
    sonar = pool.rov.sonar
    assert sonar.elevation_rad == pytest.approx(-np.radians(30))
    sonar.aim(np.radians(-60))
    assert sonar.elevation_rad == pytest.approx(-np.radians(30)), "no time has passed"
    before = sonar.ping()
    pool.advance(2.0)
    assert sonar.elevation_rad == pytest.approx(-np.radians(40), abs=1e-5)
    forward = sonar.ping().world_from_sonar[:3, 0]
    assert forward[2] == pytest.approx(-np.sin(np.radians(40)), abs=1e-5), (
        "a ping uses the present elevation, not the one at which the head is aimed"
    )
    assert before.world_from_sonar[2, 0] == pytest.approx(-0.5)
    pool.advance(10.0)
    assert sonar.elevation_rad == np.radians(-60)
    with pytest.raises(ValueError, match=r"elevation_rad = 1\.6: must be in"):
        sonar.aim(1.6)
    pool.advance(1.0)
    assert sonar.elevation_rad == np.radians(-60), "a refused aim changes nothing"


def test_the_two_way_travel_time_limits_the_ping_rate() -> None:
    deep, near = Simulator("pool", sonar_model=1).rov.sonar, Simulator("pool", sonar_model=2).rov.sonar
    assert deep.ping_rate_max_hz == pytest.approx(7.7, abs=0.15)  # fresh water, 190 m there and back
    assert near.ping_rate_max_hz / deep.ping_rate_max_hz == pytest.approx(95 / 55)


@pytest.mark.parametrize("threads", [1, 2, 3, None])
def test_a_batch_equals_single_pings(pool: Simulator, threads: int | None) -> None:
    poses = poses_in(pool, 60)
    batch = pool.rov.sonar.ping_batch(poses, threads=threads)
    assert batch.ranges_m.shape == (60, 1025)
    assert batch.points_sonar_m.shape == (60, 1025, 3)
    assert batch.world_from_sonar.shape == (60, 4, 4)
    assert batch.valid.dtype == bool
    pool.rov.release()
    for k in range(0, 60, 7):
        turn = np.arctan2(poses[k, 1, 0], poses[k, 0, 0])
        pool.rov.place(poses[k, :3, 3], [0, 0, np.sin(turn / 2), np.cos(turn / 2)])
        ping = pool.rov.sonar.ping()
        np.testing.assert_allclose(batch.world_from_sonar[k], ping.world_from_sonar, atol=1e-12)
        np.testing.assert_array_equal(batch.angles_rad, ping.angles_rad)
        np.testing.assert_array_equal(batch.valid[k], ping.valid)
        np.testing.assert_allclose(batch.ranges_m[k], ping.ranges_m, rtol=1e-6)
        np.testing.assert_array_equal(batch.labels[k], ping.labels)


def test_a_batch_is_the_same_for_any_number_of_threads(pool: Simulator) -> None:
    poses = poses_in(pool, 200)
    one, two = (pool.rov.sonar.ping_batch(poses, threads=n) for n in (1, 2))
    for name in ARRAYS:
        assert getattr(one, name).tobytes() == getattr(two, name).tobytes(), name


def test_a_batch_moves_nothing_and_may_be_empty(pool: Simulator) -> None:
    before = pool.rov.pose.position_world_m
    assert pool.rov.sonar.ping_batch(np.empty((0, 4, 4))).ranges_m.shape == (0, 1025)
    pool.rov.sonar.ping_batch(poses_in(pool, 3))
    np.testing.assert_array_equal(pool.rov.pose.position_world_m, before)


@pytest.mark.parametrize(
    ("change", "rule"),
    [
        (lambda p: p[0], r"world_from_body\.shape|poses\.shape"),
        (lambda p: p * np.nan, "must be finite"),
        (lambda p: p * 2.0, "must be a rotation and a translation"),
        (lambda p: -p, "must be a rotation and a translation"),
        (lambda p: p + np.eye(4)[3] * 1e9, "must be"),
        (lambda p: "poses", "poses"),
    ],
)
def test_invalid_poses_are_refused(pool: Simulator, change: object, rule: str) -> None:
    with pytest.raises(ValueError, match=rule):
        pool.rov.sonar.ping_batch(change(poses_in(pool, 4)))  # type: ignore[operator]


def test_an_invalid_number_of_threads_is_refused(pool: Simulator) -> None:
    with pytest.raises(ValueError, match=r"threads = 0: must be in \[1, 1024\]"):
        pool.rov.sonar.ping_batch(poses_in(pool, 1), threads=0)


def test_a_head_above_the_water_or_under_the_ground_receives_no_echo(pool: Simulator) -> None:
    poses = poses_in(pool, 3)
    poses[0, 2, 3], poses[1, 2, 3] = 2.0, -50.0
    batch = pool.rov.sonar.ping_batch(poses)
    assert not batch.valid[:2].any()
    assert batch.valid[2].any()
    assert np.isinf(batch.ranges_m[:2]).all()
    assert not np.isnan(batch.ranges_m).any()


def test_arrays_are_read_only_and_outlive_the_simulator() -> None:
    sim = Simulator("pool")
    ping, batch = sim.rov.sonar.ping(), sim.rov.sonar.ping_batch(poses_in(sim, 2))
    kept = ping.ranges_m.copy()
    del sim
    np.testing.assert_array_equal(ping.ranges_m, kept)
    for name in ARRAYS:
        for result in (ping, batch):
            with pytest.raises(ValueError, match="read-only"):
                getattr(result, name)[...] = 0
