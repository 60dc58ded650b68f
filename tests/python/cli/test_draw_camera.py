"""`uwsim camera` writes images side by side, and reports errors in one line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from uwsim import Simulator
from uwsim.cli.draw_camera import CameraRequest, set_up
from uwsim.cli.pose_option import parsed_pose
from uwsim.cli.program import app


def run(*words: str | Path) -> tuple[int, str, BaseException | None]:
    result = CliRunner().invoke(app, ["camera", *map(str, words)])
    return result.exit_code, result.output, result.exception


def test_pictures_with_and_without_effects_lie_side_by_side(tmp_path: Path) -> None:
    out = tmp_path / "pair.png"
    code, output, _ = run("pool", "--effects", "on,off", "--out", out, "--pose", "0,0,-3,10,0,0", "--jerlov", "5C")
    assert code == 0, output
    assert "2 x 640 x 360 pixels, camera 'front'" in output
    image = np.asarray(Image.open(out), np.float64)
    assert image.shape == (360, 1284, 3)
    with_water, without = image[:, :640], image[:, 644:]
    assert with_water[0, :, 1].mean() > with_water[0, :, 2].mean()  # green water
    assert without[0, :, 2].mean() > without[0, :, 1].mean()  # blue sky
    assert [path.name for path in tmp_path.iterdir()] == ["pair.png"]


def test_camera_lamps_sun_and_time_can_be_chosen(tmp_path: Path) -> None:
    lit, dark = tmp_path / "lit.jpg", tmp_path / "dark.jpg"
    common = ("pool", "--camera", "down", "--sun", "-6", "--pose", "0,0,-3,0,0,0", "--at", "0.05")
    assert run(*common, "--out", lit, "--lamps", "down,front")[0] == 0
    assert run(*common, "--out", dark)[0] == 0
    assert np.asarray(Image.open(lit)).mean() > 5 + np.asarray(Image.open(dark)).mean()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--effects", "fog"), "effects = 'fog': must be 'on', 'off' or names of attenuation"),
        (("--effects", "on,on+fog"), "effects = 'fog': must be"),
        (("--effects", "shadow"), "did you mean 'shadows'?"),
        (("--effects", "on,on+noise"), "'on' must be used alone: it means all effects"),
        (("--effects", ","), "must name at least one picture"),
        (("--camera", "rear"), "camera = 'rear': must be one of station, deck, chase, front, down"),
        (("--lamps", "rear"), "lamps = 'rear': must be one of front, down"),
        (("--pose", "1,2"), "--pose 1,2: 2 numbers; must be X,Y,Z[,YAW[,PITCH[,ROLL]]]"),
        (("--pose", "a,b,c,d,e,f"), "--pose a,b,c,d,e,f: must be X,Y,Z[,YAW[,PITCH[,ROLL]]]"),
        (("--pose", "0,0,-30,0,0,0"), "must be above the ground"),
        (("--out", "nowhere/at/all.png"), "no such folder"),
        (("--out", "picture.bmp"), "must end in .png, .jpg or .jpeg"),
    ],
)
def test_a_mistake_is_reported_in_one_line_and_nothing_is_written(
    words: tuple[str, ...], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    code, _, error = run("pool", *words)
    assert code == 1
    assert isinstance(error, ValueError)
    assert message in str(error)
    assert "\n" not in str(error)
    assert not list(tmp_path.iterdir())


def test_a_sun_out_of_bounds_is_refused() -> None:
    code, output, _ = run("pool", "--sun", "200")
    assert code == 2
    assert "--sun = 200.0 deg: must be in [-6, 90] deg" in output


def test_the_vehicle_is_where_it_was_asked_to_be_however_long_it_waits() -> None:
    sim = Simulator("pool")
    set_up(sim, CameraRequest(pose="0,0,-3,10,20,0", at_s=2.0))
    position, turn = parsed_pose("0,0,-3,10,20,0")
    np.testing.assert_allclose(sim.rov.pose.position_world_m, position)
    np.testing.assert_allclose(sim.rov.pose.orientation_xyzw, turn)
    assert sim.time_s == 2.0
