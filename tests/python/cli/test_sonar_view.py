"""`uwsim scenario sonar` and its figures: echoes are drawn where they belong, and errors take one line."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from command_line import error_line, uwsim
from uwsim.cli.draw_sonar import Request, run_sonar
from uwsim.cli.pose_option import parsed_pose
from uwsim.instruments.sonars.imaging import ForwardLooking, SonarImage
from uwsim.instruments.sonars.imaging.pixels import fan_pixels, shown_range
from uwsim.scenario import load
from uwsim.scenario.dump import write_scenario


def image_of(row: int, column: int, *, beams: int = 91, bins: int = 200, field_of_view_deg: float = 90.0) -> SonarImage:
    """Return a dark image with one bright cell."""
    model = ForwardLooking(beams=beams, range_bins=bins, field_of_view_rad=np.radians(field_of_view_deg))
    level_db = np.full((bins, beams), 20.0, np.float32)
    level_db[row, column] = 80.0
    half = model.field_of_view_rad / 2
    noise_db = np.full(bins, 20.0, np.float32)
    return SonarImage(level_db, noise_db, model.bin_centres_m, np.linspace(-half, half, beams), np.eye(4), model)


@pytest.mark.parametrize("field_of_view_deg", [90.0, 220.0])
def test_a_cell_is_drawn_at_its_range_and_bearing(field_of_view_deg: float) -> None:
    for row, column in ((100, 45), (150, 75), (60, 10)):
        image = image_of(row, column, field_of_view_deg=field_of_view_deg)
        pixels = fan_pixels(image, height=400)
        left, right, bottom, top = pixels.extent_m
        height, width = pixels.level_db.shape
        y, x = np.unravel_index(np.nanargmax(pixels.level_db), pixels.level_db.shape)
        starboard = left + (x + 0.5) / width * (right - left)
        ahead = top - (y + 0.5) / height * (top - bottom)
        range_m, bearing = image.ranges_m[row], image.bearings_rad[column]
        off_m = 0.3 + range_m * image.model.field_of_view_rad / 90
        assert ahead == pytest.approx(range_m * np.cos(bearing), abs=off_m)
        assert starboard == pytest.approx(-range_m * np.sin(bearing), abs=off_m), "port is to the left"


def test_pixels_outside_the_fan_are_empty() -> None:
    pixels = fan_pixels(image_of(1, 1), height=100)
    assert np.isnan(pixels.level_db[-1, 0])
    assert np.isnan(pixels.level_db[0, 0])
    assert np.isfinite(pixels.level_db[50, pixels.level_db.shape[1] // 2])
    with pytest.raises(ValueError, match="height"):
        fan_pixels(image_of(1, 1), height=0)


def test_shown_levels_follow_the_echoes_and_not_the_noise() -> None:
    noise_db = np.full((100, 1), 20.0, np.float32)
    level_db = np.full((100, 50), 20.0, np.float32)
    quiet = shown_range(level_db, noise_db)
    assert quiet[0] > 15.0, "noise alone is dark"
    level_db[:30] = 60.0
    low, high = shown_range(level_db, noise_db)
    assert 20.0 < low < 60.0 < high


def test_a_pose_is_read_in_degrees_nose_down() -> None:
    position, quaternion = parsed_pose("1,-2.5,-3,90,30,0")
    assert position.tolist() == [1.0, -2.5, -3.0]
    x, y, z, w = quaternion
    ahead = np.array([1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)])
    assert ahead == pytest.approx([0.0, np.cos(np.radians(30)), -0.5], abs=1e-12)
    assert parsed_pose("1,2,-3")[1].tolist() == [0.0, 0.0, 0.0, 1.0]


def test_each_kind_is_drawn_and_repeatable(tmp_path: Path) -> None:
    pool, physics = load("pool"), tmp_path / "physics.yaml"
    (rov,) = pool.vehicles
    sonar = rov.sonar.model_copy(update={"mode": "physics"})
    write_scenario(physics, pool.model_copy(update={"vehicles": (rov.model_copy(update={"sonar": sonar}),)}))

    def draw(name: str, kind: str, seed: int = 0) -> tuple[Path, list[str]]:
        out = tmp_path / f"{name}.png"
        scenario = str(physics) if kind == "water-column" else "pool"
        return out, run_sonar(Request(scenario, out, "-3,0.5,-2.5,0,0,0", kind, track_m=3.0, seed=seed))

    for kind in ("all", "water-column", "image"):  # the first draws each of the others
        out, summary = draw(kind, kind)
        pixels = np.asarray(Image.open(out).convert("L"))
        assert min(pixels.shape) > 400
        assert pixels.std() > 20.0
        for part in ("fan", "image", "side-scan", "profile") if kind == "all" else (kind,):
            assert any(line.startswith(f"{part}: ") for line in summary)
    assert draw("again", "image")[0].read_bytes() == (tmp_path / "image.png").read_bytes()
    assert draw("other", "image", seed=1)[0].read_bytes() != (tmp_path / "image.png").read_bytes()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"pose": "1,2"}, "--pose 1,2: 2 numbers"),
        ({"pose": "1,2,deep"}, "must be X,Y,Z"),
        ({"pose": "1,2,nan"}, "finite"),
        ({"pose": "0,0,2"}, "must be in the water"),
        ({"pose": "0,0,-7"}, "--pose 0,0,-7"),
        ({"kind": "hologram"}, "--kind hologram"),
        ({"track_m": 0.0}, "--track 0 m"),
        ({"tilt_deg": 120.0}, "--tilt 120 deg: must be in"),
        ({"tilt_deg": float("nan")}, "--tilt nan deg"),
        ({"pose": "0,0,-2,0,90", "kind": "side-scan"}, "needs a heading"),
        ({"sonar_model": 9}, "sonar"),
    ],
)
def test_an_error_is_named_and_leaves_no_file(tmp_path: Path, changes: dict[str, object], words: str) -> None:
    with pytest.raises(ValueError, match=re.escape(words)):
        run_sonar(replace(Request("pool", tmp_path / "a.png", kind="fan"), **changes))
    assert list(tmp_path.iterdir()) == []


def test_the_command_accepts_a_pose_that_begins_with_a_minus_and_names_an_unwritable_picture(tmp_path: Path) -> None:
    words = ("scenario", "sonar", "pool", "--pose", "-3,0.5,-2.5", "--kind", "fan", "--out")
    result = uwsim(*words, "fan.png", cwd=tmp_path)
    assert (result.returncode, result.stderr) == (0, "") and "fan: EM 2040" in result.stdout
    (tmp_path / "taken.png").mkdir()
    unwritable = {"there/is/none.png": "there is no folder", "taken.png": "is a folder", "a.jpg": "must end in .png"}
    for out, rule in unwritable.items():
        assert rule in error_line(uwsim(*words, out, cwd=tmp_path))
