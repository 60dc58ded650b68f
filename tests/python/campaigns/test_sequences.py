"""Sequences for SLAM: what the instruments measured agrees with the ground truth, by the calibration beside it."""

import csv
import hashlib
import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any, ClassVar

import cv2
import numpy as np
import pytest
import yaml as pyyaml
from numpy.typing import NDArray
from rosbags.highlevel import AnyReader
from ruamel.yaml import YAML
from scipy.spatial.transform import Rotation

import uwsim
from uwsim import Simulator
from uwsim.base.atomic_file import remove_unfinished
from uwsim.base.own_files import mark
from uwsim.base.sockets import PLANNERS, registered
from uwsim.campaigns.datasets.sequences.make import ABOUT, BAG, CHAIN, IMU, TRUTH, UNFINISHED
from uwsim.campaigns.datasets.sequences.named import FOLDER, load_sequence
from uwsim.channels.ros.message_types import ros1_typestore
from uwsim.flight.missions import SURVEY
from uwsim.flight.terminal import Silent
from uwsim.missions import wait
from uwsim.scenario import load
from uwsim.scenario.read.assets import assets_folder

BALL_M, GRAVITY_M_S2 = np.array([3.0, 0.4, -4.0]), 9.80665
WORLD = """
name: aquarium
terrain: {source: noise, size_m: [40, 40], spacing_m: 1, bed_depth_m: 8}
station: {position_m: [-12, 0, 0]}
obstacles:
  - {kind: sphere, name: ball, position_m: [3, 0.4, -4], radius_m: 0.2}
vehicles: [{name: rov, model: small.yaml, sonar: {model: 2, tilt_deg: 50}, start: {position_m: [0, 0, -4]}}]
"""
VEHICLE = """
name: small
mesh: meshes/rov.obj
centre_of_mass_m: [0, 0, 0]
density_kg_m3: 1000
max_force_n: [400, 300, 300]
max_torque_nm: [30, 40, 50]
centre_of_buoyancy_m: [0, 0, 0.1]
linear_damping: [30, 40, 50, 60, 70, 80]
quadratic_damping: [90, 100, 110, 12, 13, 14]
added_mass: [100, 200, 300, 40, 50, 60]
cameras:
  front: {position_m: [0.6, 0.1, 0.1], yaw_pitch_roll_deg: [4, 8, 2], width: 96, height: 72,
          distortion: [-0.12, 0.02, 0.001, -0.002, 0], wobble_mrad: 0}
  down: {position_m: [0.2, 0, -0.4], yaw_pitch_roll_deg: [0, 90, 0], width: 64, height: 48}
  cubic: {position_m: [0.6, 0, 0], width: 64, height: 48, distortion: [0, 0, 0, 0, 0.01]}
  turning: {position_m: [0.6, 0, 0], width: 64, height: 48, pan_tilt: {tilt_limits_deg: [-30, 30]}}
sonar: {position_m: [0.5, 0, -0.2]}
imaging_sonars:
  ahead: {kind: forward_looking, position_m: [0.6, 0, 0], range_max_m: 8, range_bins: 50, beams: 16,
          rays_per_column: 16, columns_per_beam: 1}
  aside: {kind: side_scan, range_max_m: 10, range_bins: 40, planes: 4}
sensors:
  imu: {kind: imu, rate_hz: 200, position_m: [0.1, 0.2, 0.05], yaw_pitch_roll_deg: [30, 0, 10], channels: {
        angular_velocity: {density: 1.0e-5, bias_std: 1.0e-5, bias_time_s: 50},
        linear_acceleration: {density: 1.0e-4, walk: 1.0e-5}}}
  dvl: {kind: dvl, rate_hz: 20, latency_s: 0.05, position_m: [0, 0, -0.3], yaw_pitch_roll_deg: [20, 0, 0],
        range_max_m: 50}
  depth: {kind: depth, rate_hz: 15, noise: {std: 0.001}}
"""


def mission(vehicle: Any) -> Any:
    vehicle.set_effort(surge=0.6, yaw=0.3, heave=0.2)
    yield wait(1.5)


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("world")
    (folder / "small.yaml").write_text(VEHICLE)
    (folder / "aquarium.yaml").write_text(WORLD)
    return folder / "aquarium.yaml"


@pytest.fixture(scope="module")
def sequence(world: Path, tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    """A sequence, with its tables as arrays and its calibration."""
    out = tmp_path_factory.mktemp("made") / "sequence"
    made = uwsim.make_sequence(world, mission, out, cameras=("front", "down"), seed=5, threads=2)
    return SimpleNamespace(out=out, mav=out / "mav0", made=made, chain=read(out / CHAIN))


def read(path: Path) -> Any:
    return YAML(typ="safe", pure=True).load(path.read_text())


def rows_of(folder: Path) -> list[list[str]]:
    """Return the rows of a data.csv."""
    return list(csv.reader((folder / "data.csv").open()))[1:]


def table(folder: Path) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return the stamps (n,) [ns] and the values (n, k) of a data.csv."""
    rows = rows_of(folder)
    return np.array([int(row[0]) for row in rows]), np.array([[float(value) for value in row[1:]] for row in rows])


def pose(folder: Path) -> NDArray[np.float64]:
    """Return T_BS."""
    return np.reshape(read(folder / "sensor.yaml")["T_BS"]["data"], (4, 4))


def truth(sequence: SimpleNamespace) -> SimpleNamespace:
    stamps, values = table(sequence.mav / "state_groundtruth_estimate0")
    turns = Rotation.from_quat(values[:, [4, 5, 6, 3]])
    return SimpleNamespace(stamps=stamps, position=values[:, :3], turn=turns, velocity=values[:, 7:])


def test_every_instrument_is_there_at_its_rate(sequence: SimpleNamespace) -> None:
    for name, count in sequence.made.counts.items():
        stamps = [int(row[0]) for row in rows_of(sequence.mav / name)]
        assert len(stamps) == count > 5
        steps = np.diff(stamps)
        assert (steps > 0).all()
        rate_hz = read(sequence.mav / name / "sensor.yaml")["rate_hz"]
        assert np.median(steps) == pytest.approx(1e9 / rate_hz, abs=5.1e6), "to a step of the simulation"


def test_the_imu_integrates_to_the_true_motion(sequence: SimpleNamespace) -> None:
    """Strapdown integration from the first true state, by the mount in sensor.yaml alone."""
    true, (stamps, values) = truth(sequence), table(sequence.mav / "imu0")
    body_from_imu = pose(sequence.mav / "imu0")
    mount, arm = Rotation.from_matrix(body_from_imu[:3, :3]), body_from_imu[:3, 3]
    np.testing.assert_array_equal(stamps, true.stamps)
    step_s = 1e-9 * np.diff(stamps)
    turn = true.turn[0]
    rates = mount.apply(values[:, :3])
    forces = mount.apply(values[:, 3:])
    velocity = true.velocity[0] + turn.apply(np.cross(rates[0], arm))
    position = true.position[0] + turn.apply(arm)
    for k, dt in enumerate(step_s, start=1):
        turn_before, turn = turn, turn * Rotation.from_rotvec(rates[k] * dt)
        acceleration = 0.5 * (turn_before.apply(forces[k]) + turn.apply(forces[k])) - [0, 0, GRAVITY_M_S2]
        position = position + velocity * dt + 0.5 * acceleration * dt**2
        velocity = velocity + acceleration * dt
    assert (turn.inv() * true.turn[-1]).magnitude() < 1e-3
    np.testing.assert_allclose(velocity, true.velocity[-1] + turn.apply(np.cross(rates[-1], arm)), atol=0.02)
    np.testing.assert_allclose(position, true.position[-1] + turn.apply(arm), atol=0.02)
    assert np.linalg.norm(true.position[-1] - true.position[0]) > 0.2, "it moved"


def test_the_dvl_and_the_depth_sensor_measure_the_true_motion(sequence: SimpleNamespace) -> None:
    true = truth(sequence)
    stamps, values = table(sequence.mav / "depth0")
    true_depth = -np.interp(stamps, true.stamps, true.position[:, 2])
    assert np.abs(values[:, 0] - true_depth).max() < 0.02 + 0.01 * true_depth.max()
    stamps, values = table(sequence.mav / "dvl0")
    rows = np.searchsorted(true.stamps, stamps)
    body_from_dvl = pose(sequence.mav / "dvl0")
    _, imu = table(sequence.mav / "imu0")
    rates = imu[rows, :3] @ pose(sequence.mav / "imu0")[:3, :3].T
    at_dvl = true.turn[rows].inv().apply(true.velocity[rows]) + np.cross(rates, body_from_dvl[:3, 3])
    np.testing.assert_allclose(values[:, :3], at_dvl @ body_from_dvl[:3, :3], atol=2e-3)


@pytest.mark.parametrize(("camera", "name"), [(0, "front"), (1, "down")])
def test_opencv_projects_what_is_in_the_pictures_to_where_it_is(
    sequence: SimpleNamespace, world: Path, camera: int, name: str
) -> None:
    """By the ground truth and the calibration, the ball's outline is where a camera at that pose sees its label."""
    true, folder = truth(sequence), sequence.mav / f"cam{camera}"
    calibration, body_from_optical = read(folder / "sensor.yaml"), pose(folder)
    (fu, fv, cu, cv), distortion = calibration["intrinsics"], np.array(calibration["distortion_coefficients"])
    rows = rows_of(folder)
    row = np.flatnonzero(true.stamps == int(rows[-1][0]))[0]
    picture = cv2.imread(str(folder / "data" / rows[-1][1]))
    assert picture.shape == (calibration["resolution"][1], calibration["resolution"][0], 3)
    assert picture.std() > 1.0
    world_from_body = np.eye(4)
    world_from_body[:3, :3], world_from_body[:3, 3] = true.turn[row].as_matrix(), true.position[row]
    optical_from_world = np.linalg.inv(world_from_body @ body_from_optical)
    sim = Simulator(world, seed=5)
    sim.rov.place(true.position[row], orientation_xyzw=true.turn[row].as_quat())
    points = sim.rov.cameras[name].capture(geometry_only=True).depth_m
    v, u = np.nonzero(np.isfinite(points))
    chosen = np.linspace(0, len(u) - 1, 40).astype(int)
    matrix = np.array([[fu, 0, cu], [0, fv, cv], [0, 0, 1]])
    pixels = np.column_stack([u[chosen], v[chosen]]).astype(float)
    stop = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-12)
    rays = cv2.undistortPoints(pixels[:, None], matrix, distortion, criteria=stop)[:, 0]
    depths = points[v[chosen], u[chosen], None].astype(float)
    optical = np.column_stack([rays * depths, depths])
    on_surface = (optical - optical_from_world[:3, 3]) @ optical_from_world[:3, :3]
    assert np.abs(sim.scene.distance_m(on_surface)).max() < 1e-3 * depths.max(), (
        "each pixel's point lies on a surface of the world"
    )


def test_the_chain_of_cameras_is_that_of_their_mounts(sequence: SimpleNamespace) -> None:
    body_from_imu = pose(sequence.mav / "imu0")
    for k in (0, 1):
        expected = np.linalg.inv(pose(sequence.mav / f"cam{k}")) @ body_from_imu
        np.testing.assert_allclose(sequence.chain[f"cam{k}"]["T_cam_imu"], expected, atol=1e-12)
    before = np.array(sequence.chain["cam0"]["T_cam_imu"])
    np.testing.assert_allclose(
        np.array(sequence.chain["cam1"]["T_cn_cnm1"]) @ before, sequence.chain["cam1"]["T_cam_imu"], atol=1e-12
    )
    noise = read(sequence.out / IMU)
    assert noise["gyroscope_noise_density"] == 1e-5
    assert noise["gyroscope_random_walk"] == pytest.approx(1e-5 * np.sqrt(2 / 50))
    assert noise["accelerometer_random_walk"] == 1e-5


def test_kalibrs_yaml_reader_takes_numbers_for_numbers(sequence: SimpleNamespace) -> None:
    noise = pyyaml.safe_load((sequence.out / IMU).read_text())
    assert all(isinstance(value, float) for key, value in noise.items() if key != "rostopic")


def test_the_bag_has_the_same_measurements(sequence: SimpleNamespace) -> None:
    stamps, values = table(sequence.mav / "imu0")
    seen, imu, echoes = [], [], 0
    with AnyReader([sequence.out / BAG], default_typestore=ros1_typestore()) as bag:
        topics = {connection.topic for connection in bag.connections}
        for connection, time_ns, data in bag.messages():
            message: Any = bag.deserialize(data, connection.msgtype)
            if connection.topic == "/camera/front/image_raw/compressed":
                seen.append((time_ns, bytes(message.data)))
            if connection.topic == "/imu":
                rate, force = message.angular_velocity, message.linear_acceleration
                stamp = message.header.stamp
                imu.append([stamp.sec * 10**9 + stamp.nanosec, rate.x, rate.y, rate.z, force.x, force.y, force.z])
            echoes += connection.topic == "/scan"
    assert {"/dvl", "/depth", "/points", "/ahead/image", "/aside/image", "/ground_truth/odom", "/tf_static"} <= topics
    np.testing.assert_array_equal(np.array(imu)[:, 0], stamps)
    np.testing.assert_array_equal(np.array(imu)[:, 1:], values)
    camera = sequence.mav / "cam0"
    assert seen == [(int(ns), (camera / "data" / name).read_bytes()) for ns, name in rows_of(camera)]
    assert echoes == sequence.made.counts["multibeam0"]


def test_sonar_files_give_the_levels_and_the_echoes(sequence: SimpleNamespace) -> None:
    true = truth(sequence)
    rows = rows_of(sequence.mav / "multibeam0")
    ping = np.load(sequence.mav / "multibeam0" / "data" / rows[-1][1])
    row = np.flatnonzero(true.stamps == int(rows[-1][0]))[0]
    points = ping["points_sonar_m"][ping["valid"]] @ ping["body_from_sonar"][:3, :3].T + ping["body_from_sonar"][:3, 3]
    points = true.turn[row].apply(points) + true.position[row]
    on_bed = points[np.linalg.norm(points - BALL_M, axis=1) > 0.3]
    assert len(on_bed) > 50 and np.abs(on_bed[:, 2] + 8.0).max() < 0.01
    about = read(sequence.mav / "forwardlooking0" / "sensor.yaml")
    name = rows_of(sequence.mav / "forwardlooking0")[-1][1]
    levels = cv2.imread(str(sequence.mav / "forwardlooking0" / "data" / name), cv2.IMREAD_UNCHANGED)
    assert levels.dtype == np.uint16
    assert levels.shape == (about["ranges_m"]["count"], len(about["bearings_rad"])) == (50, 16)
    level_db = about["level_db"]["offset"] + about["level_db"]["per_unit"] * levels
    assert -100.0 < level_db.min() < level_db.max() < 250.0
    waterfall = cv2.imread(str(sequence.mav / "sidescan0" / "waterfall.png"), cv2.IMREAD_UNCHANGED)
    assert waterfall.shape == (sequence.made.counts["sidescan0"], 80)


def test_evo_reads_both_ground_truths_as_the_same_trajectory(sequence: SimpleNamespace) -> None:
    files = pytest.importorskip("evo.tools.file_interface", reason="pip install evo")
    metrics = pytest.importorskip("evo.core.metrics")
    tum = files.read_tum_trajectory_file(sequence.out / TRUTH)
    euroc = files.read_euroc_csv_trajectory(sequence.mav / "state_groundtruth_estimate0" / "data.csv")
    assert tum.check()[0] and euroc.check()[0]
    np.testing.assert_allclose(tum.timestamps, euroc.timestamps, atol=1e-9)
    error = metrics.APE(metrics.PoseRelation.full_transformation)
    error.process_data((tum, euroc))
    assert error.get_statistic(metrics.StatisticsType.max) < 1e-9
    true = truth(sequence)
    assert tum.path_length == pytest.approx(np.linalg.norm(np.diff(true.position, axis=0), axis=1).sum())


def test_the_same_seed_gives_the_same_bytes_on_one_thread(
    sequence: SimpleNamespace, world: Path, tmp_path: Path
) -> None:
    again = uwsim.make_sequence(world, mission, tmp_path / "again", cameras=("front", "down"), seed=5, threads=1)
    about = json.loads((again.out / ABOUT).read_text())
    assert about == json.loads((sequence.out / ABOUT).read_text())
    files = {str(path.relative_to(again.out)): path for path in again.out.rglob("*") if path.is_file()}
    assert set(about["files"]) == set(files) - {ABOUT}
    assert {name: hashlib.sha256(path.read_bytes()).hexdigest() for name, path in files.items() if name != ABOUT} == (
        about["files"]
    )


@pytest.mark.parametrize(
    ("camera", "message"),
    [("cubic", "camera cubic: distortion k3 = 0.01: must be 0"), ("nose", r"cameras\['nose'\]: must be one of")],
)
def test_a_camera_that_cannot_be_described_is_refused(world: Path, tmp_path: Path, camera: str, message: str) -> None:
    with pytest.raises((ValueError, KeyError), match=message):
        uwsim.make_sequence(world, mission, tmp_path / "out", cameras=(camera,))
    assert not list(tmp_path.iterdir())


def test_a_flight_that_fails_or_ends_at_once_leaves_nothing(world: Path, tmp_path: Path) -> None:
    def fails(vehicle: Any) -> Any:
        yield wait(0.1)
        raise RuntimeError("a mistake")

    def turns(vehicle: Any) -> Any:
        vehicle.cameras["turning"].aim(tilt_rad=0.3)
        yield wait(0.3)

    def ends(vehicle: Any) -> Any:
        yield wait(0.1)
        remove_unfinished()  # what a second Ctrl-C calls before it ends the process
        raise KeyboardInterrupt

    with pytest.raises((KeyboardInterrupt, OSError)):
        uwsim.make_sequence(world, ends, tmp_path / "out", cameras=())
    with pytest.raises(RuntimeError, match="a mistake"):
        uwsim.make_sequence(world, fails, tmp_path / "out", cameras=())
    with pytest.raises(ValueError, match="camera turning: was turned by the mission"):
        uwsim.make_sequence(world, turns, tmp_path / "out", cameras=("turning",))
    assert not list(tmp_path.iterdir())
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "mine").touch()
    with pytest.raises(ValueError, match="exists already"):
        uwsim.make_sequence(world, fails, tmp_path / "out", cameras=())


def test_the_folder_gets_its_name_only_when_it_is_complete(world: Path, tmp_path: Path) -> None:
    """A killed process leaves a folder with another name, which the next run removes."""
    left = tmp_path / ("out" + UNFINISHED)
    (left / "mav0" / "cam0").mkdir(parents=True)
    (left / BAG).write_bytes(b"half")
    mark(left, unfinished=True)

    def looks(vehicle: Any) -> Any:
        yield wait(0.1)
        assert not (tmp_path / "out").exists()
        assert (left / "mav0" / "imu0" / "data.csv").exists() and not (left / ABOUT).exists()

    made = uwsim.make_sequence(world, looks, tmp_path / "out", cameras=())
    assert made.counts["imu0"] == 20 and not left.exists()
    assert (tmp_path / "out" / ABOUT).exists()


def test_chosen_instruments_are_written_with_the_same_bytes_and_the_cost_is_shown(
    sequence: SimpleNamespace, world: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Heard(Silent):
        said: ClassVar[list[str]] = []

        def message(self, text: str) -> None:
            self.said.append(text)

    monkeypatch.setattr("uwsim.campaigns.datasets.sequences.make.COST_AFTER_S", 0.5)
    options = {"cameras": (), "instruments": ("imu", "dvl", "multibeam"), "without": ("multibeam",), "bag": False}
    made = uwsim.make_sequence(world, mission, tmp_path / "out", seed=5, screen=Heard(), **options)
    assert set(made.counts) == {"state_groundtruth_estimate0", "imu0", "dvl0"}
    assert not (made.out / BAG).exists()
    for name in made.counts:
        assert (made.out / "mav0" / name / "data.csv").read_bytes() == (sequence.mav / name / "data.csv").read_bytes()
    (cost,) = [text for text in Heard.said if "for each simulated second" in text]
    assert cost.startswith("the first 0.5 s: ") and " MB " in cost
    assert repr(made).startswith(f"<Sequence '{made.out}': 1.5 s, 300 state") and "\n" not in repr(made)
    with pytest.raises(ValueError, match=r"instrument 'dlv': must be one of imu, dvl, .*did you mean 'dvl'"):
        uwsim.make_sequence(world, mission, tmp_path / "no", without=("dlv",))
    assert not (tmp_path / "no").exists()


def test_baselines_estimate_the_track_and_leave_the_measurements_as_they_are(world: Path, tmp_path: Path) -> None:
    files = {}
    for baselines in (False, True):
        out = tmp_path / str(baselines)
        options = {"cameras": (), "without": ("ahead", "aside"), "bag": False, "seed": 5}
        made = uwsim.make_sequence(world, mission, out, baselines=baselines, **options)
        files[baselines] = {str(each.relative_to(out)): each.read_bytes() for each in out.rglob("*.*")}
    found = json.loads(files[True].pop(ABOUT))["baselines"]
    assert found == made.baselines and set(found) == {"reckoning", "filter"}
    true = np.loadtxt(tmp_path / "True" / TRUTH)
    for name, errors in found.items():
        track = np.loadtxt(files[True].pop(f"baselines/{name}.tum").decode().splitlines())
        at = np.searchsorted(true[:, 0], track[:, 0])
        off_m = np.linalg.norm(track[:, 1:4] - true[at, 1:4], axis=1)
        assert errors["rms_m"] == pytest.approx(np.sqrt(np.mean(off_m**2)), abs=1e-4)
        assert 0.0 < errors["rms_m"] <= errors["largest_m"] < 0.5
    files[False].pop(ABOUT)
    assert files[True] == files[False]


def test_every_packaged_sequence_names_what_exists() -> None:
    names = sorted(path.stem for path in (assets_folder() / FOLDER).glob("*.yaml"))
    assert len(names) == 3
    for name in names:
        spec = load_sequence(name)
        assert spec.name == name and spec.mission in (SURVEY, *registered(PLANNERS))
        model = load(spec.scenario).vehicles[0].model
        assert set(spec.cameras) <= set(model.cameras)
        assert set(spec.instruments or ()) - {"multibeam"} <= set(model.sensors)
