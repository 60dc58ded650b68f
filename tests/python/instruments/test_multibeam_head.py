"""The multibeam head: its elevation, its ping rate, and batches of pings."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from uwsim import Simulator

ARRAYS = ("ranges_m", "points_sonar_m", "incidence_rad", "intensity_db", "labels", "valid")


@pytest.fixture(scope="module")
def shared() -> Simulator:
    return Simulator("pool", sonar_model=4)


@pytest.fixture
def pool(shared: Simulator) -> Simulator:
    shared.reset()
    return shared


def poses_in(pool: Simulator, count: int) -> np.ndarray:
    random = np.random.default_rng(3)
    poses = np.tile(pool.rov.pose.world_from_body, (count, 1, 1))
    poses[:, :3, :3] = Rotation.from_euler("z", random.uniform(-np.pi, np.pi, (count, 1))).as_matrix()
    poses[:, :3, 3] = random.uniform([-3, -3, -4], [3, 3, -1], (count, 3))
    return poses


def test_the_head_starts_at_the_scenarios_tilt_and_turns_at_five_degrees_per_second(pool: Simulator) -> None:
    sonar = pool.rov.sonar
    sonar.aim(np.radians(-60))
    assert sonar.elevation_rad == pytest.approx(-np.radians(30)), "no time has passed"
    before = sonar.ping()
    pool.advance(2.0)
    for pose, dip_deg in ((before, 30), (sonar.ping(), 40)):
        assert pose.world_from_sonar[2, 0] == pytest.approx(-np.sin(np.radians(dip_deg)), abs=1e-5), "where it is"
    pool.advance(10.0)
    with pytest.raises(ValueError, match=r"elevation_rad = 1\.6: must be in"):
        sonar.aim(1.6)
    pool.advance(1.0)
    assert sonar.elevation_rad == np.radians(-60), "a refused aim changes nothing"


def test_a_batch_equals_single_pings_with_any_number_of_threads(pool: Simulator) -> None:
    poses, before = poses_in(pool, 60), pool.rov.pose.position_world_m
    poses[1, 2, 3], poses[2, 2, 3] = 2.0, -50.0  # in the air and in the ground
    batch, *others = (pool.rov.sonar.ping_batch(poses, threads=threads) for threads in (1, 2, 3, None))
    for other in others:
        assert all(getattr(batch, name).tobytes() == getattr(other, name).tobytes() for name in ARRAYS)
    assert pool.rov.sonar.ping_batch(np.empty((0, 4, 4))).ranges_m.shape == (0, 1025)
    np.testing.assert_array_equal(pool.rov.pose.position_world_m, before)
    assert batch.ranges_m.shape == (60, 1025)
    assert batch.points_sonar_m.shape == (60, 1025, 3)
    assert batch.world_from_sonar.shape == (60, 4, 4)
    assert batch.valid.dtype == bool and not batch.valid[1:3].any() and not np.isnan(batch.ranges_m).any()
    pool.rov.release()
    for k in range(0, 60, 7):
        pool.rov.place(poses[k, :3, 3], Rotation.from_matrix(poses[k, :3, :3]).as_quat())
        ping = pool.rov.sonar.ping()
        np.testing.assert_allclose(batch.world_from_sonar[k], ping.world_from_sonar, atol=1e-12)
        np.testing.assert_array_equal(batch.angles_rad, ping.angles_rad)
        np.testing.assert_array_equal(batch.valid[k], ping.valid)
        np.testing.assert_allclose(batch.ranges_m[k], ping.ranges_m, rtol=1e-6)
        np.testing.assert_array_equal(batch.labels[k], ping.labels)


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
    with pytest.raises(ValueError, match=r"threads = 0: must be in \[1, 1024\]"):
        pool.rov.sonar.ping_batch(poses_in(pool, 1), threads=0)


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
