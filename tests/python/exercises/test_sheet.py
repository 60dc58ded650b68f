"""The score sheet is written whatever the titles are and whatever fails, and no old one stays beside a new score."""

import json
from unittest.mock import patch

import pytest

from uwsim.base.own_files import mark
from uwsim.exercises import Exercise, load_exercise
from uwsim.exercises.flight import fly_exercise
from uwsim.exercises.sheet import NAMES
from uwsim.missions import wait

pytestmark = pytest.mark.usefixtures("blank_figures")
TITLE = r"Hold $\frac{ & <b>5 $"


def still(vehicle):
    yield wait(2.0)


def exercise(title: str = TITLE) -> Exercise:
    values = {
        "title": title, "brief": title, "scenario": "pool", "time_s": 2, "pass_points": 5,
        "start": {"position_m": [0, 0, -2.5]},
        "goals": [{"kind": "hold", "name": "still", "title": title, "depth_m": 2.5, "for_s": 1}],
    }  # fmt: skip
    return Exercise.model_validate(values)


def test_a_title_may_have_any_character_and_a_figure_may_fail(tmp_path):
    fly_exercise(exercise(), still, tmp_path)
    page = (tmp_path / "sheet.html").read_text()
    assert r"Hold $\frac{ &amp; &lt;b&gt;5 $" in page and page.count("data:image/png") == 3
    with patch("uwsim.figures.exercise.draw_errors", side_effect=RuntimeError("no ink")):
        fly_exercise(exercise(), still, tmp_path)
    page = (tmp_path / "sheet.html").read_text()
    assert "This figure could not be drawn: no ink" in page and page.count("data:image/png") == 2
    assert json.loads((tmp_path / "score.json").read_text())["score"] == 10.0


def test_a_stale_sheet_goes_before_the_flight_and_a_call_in_vain_leaves_it(tmp_path):
    fly_exercise(exercise("Old"), still, tmp_path)
    before = {name: (tmp_path / name).read_bytes() for name in NAMES}
    with pytest.raises((OSError, ValueError)):
        fly_exercise(exercise(), "no-such-pilot.py", tmp_path)
    assert {name: (tmp_path / name).read_bytes() for name in NAMES} == before

    def pilot(vehicle):
        yield wait(0.2)
        seen.append([name for name in NAMES if (tmp_path / name).exists()])

    seen: list[list[str]] = []
    fly_exercise(exercise("New"), pilot, tmp_path)
    assert seen == [[]]
    assert "Old" not in (tmp_path / "sheet.html").read_text() + (tmp_path / "score.json").read_text()


def test_a_file_that_uwsim_did_not_write_is_neither_removed_nor_replaced(tmp_path):
    fly_exercise(exercise("Old"), still, tmp_path)
    written = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    for name in NAMES:
        (tmp_path / name).write_text("mine\n")
        with pytest.raises(FileExistsError, match=f"{name}': exists, and uwsim did not write it as it is"):
            fly_exercise(load_exercise("hover"), still, tmp_path)
        assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == written | {name: b"mine\n"}
        (tmp_path / name).write_bytes(written[name])
        mark(tmp_path / name)


def test_a_pilot_who_fails_has_a_sheet(tmp_path):
    def pilot(vehicle):
        yield wait(0.2)
        raise KeyError("lost")

    with pytest.raises(KeyError):
        fly_exercise(exercise(), pilot, tmp_path)
    sheet = json.loads((tmp_path / "score.json").read_text())
    assert sheet["ended_because"].startswith("the pilot failed") and not sheet["has_passed"]
    assert (tmp_path / "sheet.html").is_file()
