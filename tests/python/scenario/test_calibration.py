"""Calibrations of cameras: files by ROS and OpenCV, and cameras that have them."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest

from uwsim import Simulator
from uwsim.base import lens_model
from uwsim.exercises.goals.look_at import LookAt
from uwsim.recording.capsule import pack, unpack
from uwsim.scenario import load
from uwsim.scenario.dump import write_scenario
from uwsim.scenario.fingerprint import scenario_fingerprint
from uwsim.scenario.read.calibration import CalibrationWarning, read_calibration, write_calibration

POOL = Path(__file__).parents[3] / "assets" / "scenarios" / "pool.yaml"
WIDTH, HEIGHT = 320, 240
D = (-0.21, 0.06, 0.002, -0.0015, -0.008)
LENS = {"fx": 210.5, "fy": 214.0, "cx": 151.25, "cy": 127.5, "distortion_model": "plumb_bob", "distortion": D}
MODELS = {
    "plumb_bob": D,
    "rational_polynomial": (0.93, 0.166, -2e-4, 1e-4, 0.003, 1.33, 0.436, 0.028),
    "equidistant": (-0.0292, 0.0208, -0.0319, 0.0166),
}
K = np.array([[210.5, 0.0, 151.25], [0.0, 214.0, 127.5], [0.0, 0.0, 1.0]])
PIXELS = np.stack(np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT)), axis=2).astype(float)
ROS = """
image_width: 320
image_height: 240
camera_name: front
camera_matrix: {rows: 3, cols: 3, data: [210.5, 0., 151.25, 0., 214., 127.5, 0., 0., 1.]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [-0.21, 0.06, 0.002, -0.0015, -0.008]}
rectification_matrix: {rows: 3, cols: 3, data: [1., 0., 0., 0., 1., 0., 0., 0., 1.]}
projection_matrix: {rows: 3, cols: 4, data: [180., 0., 150., 0., 0., 182., 127., 0., 0., 0., 1., 0.]}
"""


def station_camera(folder: Path, mount: str) -> Any:
    """Return a camera of the pool's station with these keys, in flow style."""
    odd = f"  dock_m: [0, 0, -2]\n  cameras: {{odd: {{position_m: [0, 0, 3], {mount}}}}}"
    (folder / "pool.yaml").write_text(POOL.read_text().replace("  dock_m: [0, 0, -2]", odd))
    return Simulator(folder / "pool.yaml", threads=2).cameras["odd"]


def stated(**lens: Any) -> str:
    listed = {key: list(value) if isinstance(value, tuple) else value for key, value in lens.items()}
    return ", ".join(f"{key}: {value}" for key, value in listed.items())


def by_opencv(rays: Any, k: Any, d: Any) -> Any:
    """Return the pixels (n, 2) of rays (n, 2) in float64."""
    points, none = np.column_stack([rays, np.ones(len(rays))])[:, None], np.zeros(3)
    project = cv2.fisheye.projectPoints if len(d) == 4 else cv2.projectPoints
    args = (points, none, none, k, np.array(d))
    return project(*args)[0].reshape(-1, 2)


@pytest.mark.parametrize("d", MODELS.values(), ids=MODELS)
def test_pixels_are_those_of_opencv(d: Any) -> None:
    rays = np.stack(np.meshgrid(np.linspace(-1.4, 1.4, 41), np.linspace(-1.0, 1.0, 31)), axis=2).reshape(-1, 2)
    ours = np.column_stack(lens_model.project(K, d, *rays.T))
    np.testing.assert_allclose(ours, by_opencv(rays, K, d), atol=1e-9)
    assert lens_model.shows(d, *rays.T).all()


def test_a_fold_is_where_rays_turn_back() -> None:
    angle_rad, bent = lens_model.largest_angle((-0.2, 0.0, 0.0, 0.0, 0.0))
    r = np.sqrt(1.0 / 0.6)  # the derivative of r - 0.2 r^3 is 0
    assert angle_rad == pytest.approx(np.arctan(r), abs=2e-3)
    assert bent == pytest.approx(r - 0.2 * r**3, abs=1e-5)
    assert not lens_model.shows((-0.2, 0, 0, 0, 0), np.array([1.4]), np.array([0.0])).any()


@pytest.mark.parametrize("model", MODELS)
def test_opencv_projects_the_rays_onto_their_pixels(tmp_path: Path, model: str) -> None:
    lens = {**LENS, "distortion_model": model, "distortion": MODELS[model]}
    camera = station_camera(tmp_path, stated(width=WIDTH, height=HEIGHT, **lens))
    assert (camera.info.distortion_model, *camera.info.d) == (model, *MODELS[model])
    seen = by_opencv(camera.ray_table().astype(float).reshape(-1, 2), K, MODELS[model])
    np.testing.assert_allclose(seen, PIXELS.reshape(-1, 2), atol=1e-3)
    write_calibration(tmp_path / "front.yaml", camera.info)
    assert read_calibration(tmp_path / "front.yaml") == {"width": WIDTH, "height": HEIGHT, **lens}


def test_calibrate_camera_finds_the_stated_calibration(tmp_path: Path) -> None:
    camera = station_camera(tmp_path, stated(width=WIDTH, height=HEIGHT, **LENS))
    np.testing.assert_array_equal(camera.info.k, K)
    rays, pixels = camera.ray_table().astype(float), PIXELS
    boards, seen = [], []
    for turn in ((0.5, 0.0, 0.1), (-0.4, 0.3, 0.0), (0.1, -0.5, 0.3), (0.3, 0.4, -0.2), (-0.2, -0.3, 0.7)):
        rotation, place = cv2.Rodrigues(np.array(turn))[0], np.array([0.02, -0.01, 1.0])
        directions = np.dstack([rays, np.ones(rays.shape[:2])])[5::23, 5::31].reshape(-1, 3)
        depths = rotation[:, 2] @ place / (directions @ rotation[:, 2])  # where the rays meet the board
        boards.append(((directions * depths[:, None] - place) @ rotation).astype(np.float32))
        seen.append(pixels[5::23, 5::31].reshape(-1, 1, 2).astype(np.float32))
    stop = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 200, 1e-12)
    _, k, d, *_ = cv2.calibrateCamera(boards, seen, (WIDTH, HEIGHT), None, None, criteria=stop)
    np.testing.assert_allclose(k, K, atol=0.01)
    np.testing.assert_allclose(d.ravel(), LENS["distortion"], atol=1e-3)


def test_a_resized_camera_sees_the_same(tmp_path: Path) -> None:
    camera = station_camera(tmp_path, stated(width=WIDTH, height=HEIGHT, **LENS))
    double = camera.resized(2 * WIDTH)
    four = double.ray_table()[100:102, 60:62].astype(float)  # around the centre of pixel 30, 50
    np.testing.assert_allclose(four.mean(axis=(0, 1)), camera.ray_table()[50, 30], atol=1e-5)
    assert double.mount.field_of_view_deg == pytest.approx(camera.mount.field_of_view_deg)
    pinhole = camera.rectified()
    np.testing.assert_allclose(pinhole.info.p, camera.info.p)
    assert pinhole.ray_table()[0, 0] == pytest.approx((-K[0, 2] / K[0, 0], -K[1, 2] / K[1, 1]))


@pytest.mark.parametrize("suffix", [".yaml", ".yml"])
def test_a_written_calibration_is_read_back(tmp_path: Path, suffix: str) -> None:
    camera = station_camera(tmp_path, stated(width=WIDTH, height=HEIGHT, **LENS))
    file = tmp_path / f"front{suffix}"
    write_calibration(file, camera.info, "front")
    assert read_calibration(file) == {"width": WIDTH, "height": HEIGHT, **LENS}
    other = station_camera(tmp_path, f"calibration: front{suffix}")
    np.testing.assert_array_equal(other.ray_table(), camera.ray_table())
    half = station_camera(tmp_path, f"calibration: front{suffix}, width: 160")
    assert (half.info.width, half.info.height) == (160, 120)
    assert half.info.k[:2] == pytest.approx(camera.resized(160).info.k[:2])
    if suffix == ".yml":
        stored = cv2.FileStorage(str(file), cv2.FILE_STORAGE_READ)
        np.testing.assert_array_equal(stored.getNode("camera_matrix").mat(), K)
        np.testing.assert_array_equal(stored.getNode("distortion_coefficients").mat()[0], LENS["distortion"])


def test_files_of_ros_and_opencv_are_read(tmp_path: Path) -> None:
    (tmp_path / "ost.yaml").write_text(ROS)
    assert read_calibration(tmp_path / "ost.yaml") == {"width": WIDTH, "height": HEIGHT, **LENS}
    store = cv2.FileStorage(str(tmp_path / "cv.yml"), cv2.FILE_STORAGE_WRITE)
    store.write("K", K)
    store.write("D", np.array([LENS["distortion"]]))
    store.release()
    assert read_calibration(tmp_path / "cv.yml") == LENS
    with pytest.raises(ValueError, match=r"cv\.yml: holds no image_width"):
        station_camera(tmp_path, "calibration: cv.yml")
    assert station_camera(tmp_path, "calibration: cv.yml, width: 320, height: 240").info.k[0, 0] == LENS["fx"]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("camera_matrix", "matrix", "ost.yaml: camera_matrix: missing"),
        ("214.,", "west,", "ost.yaml:5: camera_matrix: must be a list of finite numbers"),
        ("214.,", f"{10**400},", "ost.yaml:5: camera_matrix: must be a list of finite numbers"),
        ("width: 320", f"width: {10**400}", "must be two numbers of pixels, at most 1000000"),
        ("214.", "0.", "fy = 0 pixels: must be above 0"),
        ("plumb_bob", "mei", "distortion_model = 'mei': must be one of plumb_bob, rational_polynomial, equidistant"),
        ("plumb_bob", "equidistant", "5 coefficients of distortion: equidistant has at most k1, k2, k3, k4"),
        ("plumb_bob\n", "''\n", "distortion_model: missing: 4 coefficients"),
        ("camera_matrix: {", "left: {camera_matrix: [1]}\nother: {", "camera_matrix: missing; left have one"),
        ("image_width: 320\n", "", r"image_width, image_height = \[240\]: must be two"),
    ],
)
def test_what_is_no_calibration_is_refused(tmp_path: Path, old: str, new: str, message: str) -> None:
    text = ROS.replace(old, new, 1)
    (tmp_path / "ost.yaml").write_text(text.replace(", -0.008", "") if "4 coeff" in message else text)
    with pytest.raises(ValueError, match=message):
        read_calibration(tmp_path / "ost.yaml")


def test_a_principal_point_beyond_the_picture_is_named(tmp_path: Path) -> None:
    (tmp_path / "ost.yaml").write_text(ROS.replace("width: 320", "width: 150"))
    with pytest.warns(CalibrationWarning, match=r"cx = 151.25 is beyond the picture's 150 pixels"):
        read_calibration(tmp_path / "ost.yaml")


def test_a_model_is_what_its_coefficients_are() -> None:
    eight = (0.1, 0.2, 0.0, 0.0, 0.3, 0.4, 0.5, 0.6)
    assert lens_model.coefficients("plumb_bob", eight) == ("rational_polynomial", eight)  # as in old files
    assert lens_model.coefficients("rational_polynomial", (*eight[:5], 0, 0, 0)) == ("plumb_bob", eight[:5])
    assert lens_model.coefficients("fisheye", eight[:4]) == ("equidistant", eight[:4])
    assert lens_model.coefficients("plumb_bob", eight[:4]) == ("plumb_bob", (*eight[:4], 0.0))
    assert lens_model.coefficients("", (*eight, 0.0, 0.0, 0.0, 0.0)) == ("rational_polynomial", eight)


@pytest.mark.parametrize(
    ("mount", "message"),
    [
        ("fx: 300", "fy: missing: give all or none of fx, fy, cx, cy"),
        ("fx: 300, fy: 300, cx: 320, cy: 180, field_of_view_deg: 80", "field_of_view_deg = 80.*beside fx, fy, cx, cy"),
        ("fx: 20, fy: 20, cx: 320, cy: 180", r"fx = 20 pixels: .*, 173 deg, must be in \[1, 170\] deg"),
        ("calibration: ost.yaml, field_of_view_deg: 80", "field_of_view_deg = 80.*beside fx, fy, cx, cy"),
        ("calibration: ost.yaml, fx: 300", r"fx = 300: must be that of calibration, 210.5, or left out"),
        ("calibration: other.yaml", "no such file"),
        (
            "distortion_model: equidistant, distortion: [0, 0, 0, 0, 0]",
            "must be k1, k2, k3, k4, as distortion_model is",
        ),
    ],
)
def test_a_camera_has_one_lens(tmp_path: Path, mount: str, message: str) -> None:
    (tmp_path / "ost.yaml").write_text(ROS)
    with pytest.raises(ValueError, match=message):
        station_camera(tmp_path, mount)


def test_a_fold_within_the_picture_is_named_and_the_picture_continues(tmp_path: Path) -> None:
    lens = {"fx": 210, "fy": 210, "cx": 160, "cy": 120, "distortion": (-0.2, 0, 0, 0, -0.05)}
    camera = station_camera(tmp_path, stated(width=WIDTH, height=HEIGHT, **lens))
    with pytest.warns(
        CalibrationWarning, match=r"over 4\d\.\d deg from the axis, 1\d\d pixels from .* % of its pixels"
    ):
        rays = camera.ray_table()
    assert (np.diff(np.diagonal(rays[:, 40:280, 0]).astype(float)) > 0.0).all()
    assert camera.capture(geometry_only=True).depth_m.shape == (HEIGHT, WIDTH)


def test_a_calibrated_scenario_is_written_and_packed(tmp_path: Path) -> None:
    (tmp_path / "ost.yaml").write_text(ROS)
    station_camera(tmp_path, "calibration: ost.yaml, width: 160")
    scenario = load(tmp_path / "pool.yaml")
    write_scenario(tmp_path / "written.yaml", scenario)
    assert load(tmp_path / "written.yaml") == scenario
    packed = unpack(pack(scenario), tmp_path / "packed")
    assert packed.station.cameras["odd"].fx == scenario.station.cameras["odd"].fx == 0.5 * LENS["fx"]
    assert scenario_fingerprint(packed) == scenario_fingerprint(scenario)


def test_a_goal_looks_through_the_lens() -> None:
    sim = Simulator("pool", threads=2)
    sim.rov.place((0.0, 0.0, -3.0))
    camera = sim.rov.cameras["front"]
    off_centre = {"fx": 400.0, "fy": 400.0, "cx": 500.0, "cy": 180.0, "distortion": (0.0,) * 5}
    camera.change(camera.mount.model_copy(update=off_centre))
    moment = SimpleNamespace(position_world_m=np.array([0.0, 0.0, -3.0]), vehicle=sim.rov, sim=sim)
    words = {"name": "look", "title": "Look", "kind": "look_at", "position_m": (0, 0, 0), "cameras": ["front"]}
    pose, goal = camera.world_from_camera, LookAt.model_validate(words)
    in_view = [goal.is_in_view(moment, (pose @ (1.0, y, 0.0, 1.0))[:3]) for y in (1.2, -0.3, -0.4)]  # y is to port
    assert in_view == [True, True, False]  # at pixels 20, 620 and 660 of 640


def test_parameters_know_no_field_of_view_of_a_calibrated_camera(tmp_path: Path) -> None:
    camera = station_camera(tmp_path, stated(width=WIDTH, height=HEIGHT, **LENS))
    sim = Simulator(tmp_path / "pool.yaml")
    names = [name for name in sim.parameters if ".odd." in name]
    assert any(name.endswith("exposure") for name in names)
    assert not [name for name in names if name.endswith(("field_of_view_deg", "fx"))]
    assert camera.mount.field_of_view_deg == pytest.approx(2 * np.degrees(np.arctan(160 / 210.5)))
