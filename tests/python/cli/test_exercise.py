"""`uwsim exercise`: the list, a headless flight, and what is refused."""

import json

from command_line import uwsim
from uwsim.exercises import exercise_names

PILOT = """\
from uwsim.missions import goto


def mission(vehicle):
    yield from goto(vehicle, (0, 0, -2.5), within_m=0.3)
"""


def test_the_list_names_every_packaged_exercise():
    listed = uwsim("exercise")
    assert listed.returncode == 0
    assert [line.split()[0] for line in listed.stdout.splitlines()] == exercise_names()


def test_a_pilot_who_does_too_little_does_not_pass(tmp_path):
    (tmp_path / "pilot.py").write_text(PILOT)
    flown = uwsim("exercise", "hover", "--pilot", "pilot.py", "--out", "out", cwd=tmp_path)
    assert flown.returncode == 4, flown.stderr
    assert "20.0 of 20  Reach the middle of the pool" in flown.stdout and "not passed" in flown.stdout
    assert json.loads((tmp_path / "out/score.json").read_text())["score"] < 70
    assert (tmp_path / "out/sheet.html").is_file()


def test_what_has_no_effect_is_refused(tmp_path):
    (tmp_path / "pilot.py").write_text(PILOT)
    for words in (
        ["hover"],
        ["hover", "--pilot", "pilot.py", "--serve"],
        ["hover", "--pilot", "pilot.py", "--port", "0"],
    ):
        assert uwsim("exercise", *words, cwd=tmp_path).returncode == 2, words
    unknown = uwsim("exercise", "hoover", "--pilot", "pilot.py", cwd=tmp_path)
    assert unknown.returncode == 1 and "did you mean 'hover'" in unknown.stderr
