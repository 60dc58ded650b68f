"""`uwsim scenario camera` writes images side by side, and reports errors in one line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from command_line import error_line, uwsim
from uwsim import Simulator
from uwsim.cli.draw_camera import CameraRequest, set_up
from uwsim.cli.pose_option import parsed_pose
from uwsim.scenario.read.calibration import read_calibration


def test_pictures_with_and_without_effects_lie_side_by_side(tmp_path: Path) -> None:
    words = "scenario camera pool --effects on,off --out pair.png --pose 0,0,-3,10,0,0 --jerlov 5C"
    made = uwsim(*words.split(), cwd=tmp_path)
    assert made.returncode == 0, made.stderr
    assert "2 x 640 x 360 pixels, camera 'front'" in made.stdout
    image = np.asarray(Image.open(tmp_path / "pair.png"), np.float64)
    assert image.shape == (360, 1284, 3)
    with_water, without = image[:, :640], image[:, 644:]
    assert with_water[0, :, 1].mean() > with_water[0, :, 2].mean()  # green water
    assert without[0, :, 2].mean() > without[0, :, 1].mean()  # blue sky
    assert [path.name for path in tmp_path.iterdir()] == ["pair.png"]


def test_the_calibration_is_written_beside_the_picture(tmp_path: Path) -> None:
    written = ["scenario", "camera", "pool", "--effects", "off", "--calibration", "front.yaml"]
    assert uwsim(*written, cwd=tmp_path).returncode == 0
    assert read_calibration(tmp_path / "front.yaml")["width"] == 640
    assert "must end in .yaml (ROS) or .yml" in error_line(
        uwsim(*["scenario", "camera", "pool", "--calibration", "f.xml"], cwd=tmp_path)
    )
    assert sorted(path.name for path in tmp_path.iterdir()) == ["camera.png", "front.yaml"]


def test_camera_lamps_sun_and_time_can_be_chosen(tmp_path: Path) -> None:
    where = ["scenario", "camera", "pool", "--camera", "down"]
    common = [*where, "--sun", "-6", "--pose", "0,0,-3,0,0,0", "--at", "0.05", "--out"]
    assert uwsim(*common, "lit.jpg", "--lamps", "down,front", cwd=tmp_path).returncode == 0
    assert uwsim(*common, "dark.jpg", cwd=tmp_path).returncode == 0
    lit, dark = (np.asarray(Image.open(tmp_path / name)).mean() for name in ("lit.jpg", "dark.jpg"))
    assert lit > 5 + dark


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("--effects on,on+fog", "effects = 'fog': must be 'on', 'off' or names of attenuation"),
        ("--effects shadow", "did you mean 'shadows'?"),
        ("--effects on,on+noise", "'on' must be used alone: it means all effects"),
        ("--effects ,", "must name at least one picture"),
        ("--camera rear", "camera = 'rear': must be one of station, deck, chase, front, down"),
        ("--lamps rear", "lamps = 'rear': must be one of front, down"),
        ("--pose 0,0,-30,0,0,0", "must be above the ground"),
        ("--out nowhere/at/all.png", "no such folder"),
        ("--out picture.bmp", "must end in .png, .jpg or .jpeg"),
        ("--sun 200", "--sun = 200.0 deg: must be in [-6, 90] deg"),
    ],
)
def test_a_mistake_is_reported_in_one_line_and_nothing_is_written(words: str, message: str, tmp_path: Path) -> None:
    assert message in error_line(uwsim("scenario", "camera", "pool", *words.split(), cwd=tmp_path))
    assert not list(tmp_path.iterdir())


def test_the_vehicle_is_where_it_was_asked_to_be_however_long_it_waits() -> None:
    sim = Simulator("pool")
    set_up(sim, CameraRequest(pose="0,0,-3,10,20,0", at_s=2.0))
    position, turn = parsed_pose("0,0,-3,10,20,0")
    np.testing.assert_allclose(sim.rov.pose.position_world_m, position)
    np.testing.assert_allclose(sim.rov.pose.orientation_xyzw, turn)
    assert sim.time_s == 2.0


def test_the_first_vehicle_is_where_the_scenario_is_seen_best_unless_a_pose_is_given() -> None:
    with Simulator("lake") as sim:
        docked = np.array(sim.rov.pose.position_world_m)
        view = sim.scenario.view
        set_up(sim, CameraRequest())
        assert np.allclose(sim.rov.pose.position_world_m, view.position_m)
        assert np.degrees(sim.rov.pose.yaw_rad) == pytest.approx(view.yaw_deg)
        set_up(sim, CameraRequest(pose=",".join(str(part) for part in docked)))
        assert np.allclose(sim.rov.pose.position_world_m, docked)
