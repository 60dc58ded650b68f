"""The public API of the simulator and its vehicles, as used in scripts and notebooks."""

import signal
import threading
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh

import uwsim
from uwsim import Simulator
from uwsim.scenario.read.assets import assets_folder


@pytest.fixture
def pool() -> Simulator:
    return Simulator("pool")


def fly_ahead(sim: Simulator, duration_s: float) -> None:
    sim.rov.release()
    sim.rov.set_effort(surge=0.5, yaw=-0.1)
    sim.advance(duration_s)


def test_time_is_a_whole_number_of_fixed_steps(pool: Simulator) -> None:
    pool.step(3)
    pool.advance(0.5)
    assert pool.time_ns == round((3 * pool.step_s + 0.5) * 1e9)
    with pytest.raises(ValueError, match=r"0\.0123 s: must be a whole number of steps"):
        pool.advance(0.0123)
    with pytest.raises(ValueError, match="must be a whole number, not negative"):
        pool.step(-1)


def test_efforts_follow_the_axes_of_rep_103(pool: Simulator) -> None:
    fly_ahead(pool, 2.0)
    velocity = pool.rov.velocity
    assert velocity.linear_body_m_s[0] > 0.1
    assert velocity.angular_body_rad_s[2] < -0.01
    pool.rov.set_effort(surge=0.2)
    np.testing.assert_array_equal(pool.rov.effort, [0.2, 0, 0, 0, 0, 0])


def test_reading_and_pinging_do_not_advance_time_and_give_the_same_again(pool: Simulator) -> None:
    fly_ahead(pool, 1.0)
    rov, before = pool.rov, pool.time_ns
    first, second = rov.sonar.ping(), rov.sonar.ping()
    np.testing.assert_array_equal(first.ranges_m, second.ranges_m)
    for sensor in rov.sensors.values():
        if isinstance(sensor.read(), float):
            assert sensor.read() == sensor.read()
    assert pool.time_ns == before == first.time_ns


def test_the_same_seed_gives_the_same_bits_and_another_seed_other_noise() -> None:
    def run(seed: int) -> tuple[bytes, float]:
        sim = Simulator("pool", seed=seed)
        fly_ahead(sim, 3.0)
        return sim.rov.pose.world_from_body.tobytes() + sim.rov.sonar.ping().ranges_m.tobytes(), sim.rov.sensors[
            "depth"
        ].read()

    assert run(7) == run(7)
    assert run(7)[1] != run(8)[1]


def test_a_pings_arrays_agree_with_each_other(pool: Simulator) -> None:
    pool.rov.sonar.aim(elevation_rad=-0.5)
    pool.advance(3.0)  # until the head is in position
    ping = pool.rov.sonar.ping()
    beams = len(ping.ranges_m)
    assert beams == 513
    assert ping.ranges_m.dtype == np.float32
    assert ping.points_sonar_m.shape == (beams, 3)
    assert ping.valid.any()
    np.testing.assert_array_equal(ping.valid, np.isfinite(ping.ranges_m))
    hit = ping.points_sonar_m[ping.valid]
    np.testing.assert_allclose(np.linalg.norm(hit, axis=1), ping.ranges_m[ping.valid], rtol=1e-6)
    np.testing.assert_allclose(np.arctan2(hit[:, 1], hit[:, 0]), ping.angles_rad[ping.valid], atol=1e-6)
    world = hit @ ping.world_from_sonar[:3, :3].T + ping.world_from_sonar[:3, 3]
    bed = ping.labels[ping.valid] == pool.world.label_names.index("terrain")
    np.testing.assert_allclose(world[bed, 2], pool.world.height_at(world[bed, :2]), atol=1e-5)


@pytest.mark.parametrize(
    ("model", "beams", "range_m"), [(1, 513, 95.0), (2, 513, 55.0), (3, 1025, 95.0), (4, 1025, 55.0)]
)
def test_the_sonar_model_is_chosen_by_argument(model: int, beams: int, range_m: float) -> None:
    sim = Simulator("pool", sonar_model=model)
    assert sim.rov.sonar.model.range_max_m == range_m
    assert len(sim.rov.sonar.ping().ranges_m) == beams


def test_panel_and_sensors_agree(pool: Simulator) -> None:
    panel, sensors = pool.rov.telemetry(), pool.rov.sensors
    assert panel.depth_m == pytest.approx(2.0)
    compressed_m = 2.0**2 * 1000 * 9.80665 / (2 * 2.2e9)  # the sensor assumes incompressible water
    assert sensors["depth"].read(noise=False) - panel.depth_m == pytest.approx(compressed_m, rel=0.1)
    assert sensors["pressure"].read(noise=False) == panel.pressure_pa
    assert panel.pressure_pa == pytest.approx(101325 + 1000 * 9.80665 * (2.0 + compressed_m), abs=0.02)
    assert panel.distance_to_seabed_m == pytest.approx(3.0)
    assert panel.proximity_warning and not panel.range_warning and not panel.collision_warning
    imu = sensors["imu"].read(noise=False)
    np.testing.assert_allclose(imu.linear_acceleration_m_s2, [0, 0, 9.80665], atol=1e-12)


def test_the_panels_depth_is_that_below_the_tide_and_the_waves() -> None:
    tide = {"constituents": [{"constituent": "M2", "amplitude_m": 3.0}]}
    surface = {"kind": "airy", "amplitude_m": 0.5, "period_s": 5.0}
    terrain = {"source": "noise", "size_m": [100, 100], "spacing_m": 10, "bed_depth_m": 30}
    vehicle = {"name": "rov", "model": "rov", "start": {"position_m": [5, 0, -10]}}
    sim = Simulator({"name": "bay", "terrain": terrain, "water": {"tide": tide, "surface": surface},
                     "vehicles": [vehicle]})  # fmt: skip
    for _ in range(3):
        sim.advance(1.0)
        position_m = sim.rov.pose.position_world_m
        (surface_m,) = sim.world.water.surface_height_m(position_m[None, :2], sim.time_s)
        assert abs(surface_m) > 0.5
        assert sim.rov.telemetry().depth_m == pytest.approx(surface_m - position_m[2], abs=1e-9)


def test_the_battery_lasts_for_the_mission_time_and_then_the_thrusters_stop() -> None:
    sim = Simulator("pool", mission_time_s=2.0)
    sim.advance(5.0)
    assert sim.rov.telemetry().battery_percent == 100.0, "a docked vehicle uses nothing up"
    fly_ahead(sim, 1.0)
    assert sim.rov.telemetry().battery_percent == pytest.approx(50.0)
    sim.advance(1.0)
    speed = sim.rov.telemetry().speed_m_s
    sim.advance(2.0)
    assert sim.rov.telemetry().battery_percent == 0.0
    assert sim.rov.telemetry().speed_m_s < 0.8 * speed


def pool_with_a_mesh_for_a_box(folder: Path) -> Path:
    trimesh.creation.box((1.0, 1.0, 1.0)).export(folder / "box.glb")
    text = (assets_folder() / "scenarios" / "pool.yaml").read_text()
    scenario = folder / "meshed.yaml"
    scenario.write_text(
        text.replace("kind: box", "kind: mesh\n    file: box.glb").replace("size_m: [1, 1, 1]", "scale: 1")
    )
    return scenario


@pytest.mark.parametrize("kind", ["box", "mesh"])
def test_the_vehicle_collides_where_its_sonar_sees_the_obstacle(kind: str, tmp_path: Path) -> None:
    """Driven at the box, the vehicle stops at the range that its sonar's middle beam measured."""
    pool = Simulator("pool" if kind == "box" else pool_with_a_mesh_for_a_box(tmp_path))
    rov = pool.rov
    rov.sonar.aim(0.0)
    pool.advance(5.0)  # until the head is in position
    rov.release()
    rov.place([0.0, 0.0, -4.5])
    ping = rov.sonar.ping()
    assert pool.world.label_names[ping.labels[256]] == "box"
    ahead_m = float(ping.ranges_m[256])
    rov.set_effort(surge=0.3)
    pool.advance(20.0)
    assert rov.collisions >= 1
    assert rov.telemetry().collision_warning
    bow_m = rov.pose.position_world_m[0] + 0.6
    assert bow_m == pytest.approx(ping.world_from_sonar[0, 3] + ahead_m, abs=0.05)


def test_a_vehicle_can_be_placed_at_finite_poses_only(pool: Simulator) -> None:
    pool.rov.place([1.0, 2.0, -1.5], velocity_body=[0.1, 0, 0, 0, 0, 0])
    np.testing.assert_array_equal(pool.rov.pose.position_world_m, [1.0, 2.0, -1.5])
    with pytest.raises(ValueError, match="finite"):
        pool.rov.place([float("nan"), 0.0, 0.0])
    with pytest.raises(ValueError, match=r"position_m\.shape"):
        pool.rov.place([0.0, 0.0])


def test_a_signal_handler_may_read_while_steps_run(pool: Simulator) -> None:
    seen: list[int] = []
    before = signal.signal(signal.SIGALRM, lambda *_: seen.append(pool.time_ns))
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.05)
        pool.rov.release()
        for _ in range(40):
            pool.step(20_000)
            if seen:
                break
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert seen


def test_a_step_that_diverges_moves_no_vehicle_and_names_the_one_at_fault(tmp_path: Path) -> None:
    vehicle = (assets_folder() / "vehicles" / "rov.yaml").read_text().splitlines()
    stiff = ["linear_damping: [1e6, 1e6, 1e6, 1e6, 1e6, 1e6]" if x.startswith("linear_damping") else x for x in vehicle]
    (tmp_path / "stiff.yaml").write_text("\n".join(stiff))
    text = (assets_folder() / "scenarios" / "pool.yaml").read_text()
    second = "  - {name: stiff, model: stiff.yaml, start: {position_m: [5, 5, -2]}}\nsurvey:"
    (tmp_path / "two.yaml").write_text(text.replace("survey:", second, 1))
    sim = Simulator(tmp_path / "two.yaml")
    sim.rov.release()
    sim.rov.set_effort(surge=1.0)
    sim.vehicles["stiff"].place([5, 5, -2], velocity_body=[1, 0, 0, 0, 0, 0])
    with pytest.raises(ValueError, match=r"vehicle 'stiff', step \d+: last finite state = \[.*the motion diverged"):
        sim.step(1000)
    place = sim.rov.pose.position_world_m
    with pytest.raises(ValueError, match="vehicle 'stiff', step"):
        sim.step()
    np.testing.assert_array_equal(sim.rov.pose.position_world_m, place)


@pytest.mark.parametrize("steps", [-1, 1.5, True, 2**70])
def test_the_number_of_steps_is_whole_and_not_negative(pool: Simulator, steps: object) -> None:
    with pytest.raises(ValueError, match="steps: must be"):
        pool.step(steps)  # type: ignore[arg-type]


def test_calls_from_several_threads_wait_for_each_other(pool: Simulator) -> None:
    pool.rov.release()
    stepper = threading.Thread(target=pool.step, args=(5000,))
    stepper.start()
    for _ in range(50):
        assert np.isfinite(pool.rov.pose.position_world_m).all()
        assert pool.rov.sonar.ping().valid.any()
    stepper.join()
    assert pool.time_ns == 5000 * round(pool.step_s * 1e9)


@pytest.mark.parametrize("threads", [0, -1, 5000])
def test_the_number_of_threads_is_checked(threads: int) -> None:
    with pytest.raises(ValueError, match="threads"):
        Simulator("pool", threads=threads)


def test_the_simulator_is_a_context_manager_and_the_package_has_a_version() -> None:
    with Simulator("pool") as sim:
        assert sim.vehicles["rov"] is sim.rov
    assert uwsim.__version__[0].isdigit()


def test_pose_and_telemetry_are_made_once_a_moment_and_anew_after_every_change() -> None:
    sim = Simulator("lake", seed=1)
    rov = sim.rov

    def changes(what: str, change: Callable[[], object]) -> None:
        before = rov.pose, rov.velocity, rov.telemetry()
        assert (rov.pose, rov.velocity, rov.telemetry()) == before, "the same objects"
        change()
        state, panel = sim._core.state(0), sim._core.telemetry(0)
        assert np.array_equal(rov.pose.world_from_body, state.world_from_body), what
        assert np.array_equal(rov.velocity.linear_body_m_s, state.velocity_body[:3]), what
        np.testing.assert_equal(rov.telemetry().to_dict(), panel.to_dict(), what)

    changes("release", rov.release)
    saved = sim.save_state()
    rov.set_effort(surge=1.0)
    changes("step", lambda: sim.step(50))
    changes("place", lambda: rov.place((-60.0, -40.0, -14.0), velocity_body=(0.5, 0, 0, 0, 0, 0)))
    changes("step", lambda: sim.step(50))
    changes("restore_state", lambda: sim.restore_state(saved))
    changes("step", lambda: sim.step(50))
    changes("reset", lambda: sim.reset(seed=2))
    changes("undock", rov.undock)
