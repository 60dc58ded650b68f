"""A sheet names person, date and build, and a changed one is noticed."""

import json
from datetime import datetime

import pytest

from command_line import error_line, uwsim
from test_sheet import exercise, still
from uwsim.exercises.certified import PERSON_MAX, digest_of, read_sheet
from uwsim.exercises.conduct import ACTS_MAX, Conduct
from uwsim.exercises.exercise import Exercise
from uwsim.exercises.flight import fly_exercise
from uwsim.exercises.limits import Area, Collisions
from uwsim.missions import wait
from uwsim.scenario.fingerprint import build_fingerprint

pytestmark = pytest.mark.usefixtures("blank_figures")


def acting(vehicle):
    vehicle.lamps["front"].on = True
    for _ in range(30):
        vehicle.command("note", text="again", category="defect", position_world_m=None)
        yield wait(0.05)


def limited() -> Exercise:
    limits = [Collisions(kind="collision", cost=20), Area(kind="area", area_m=[(9, 9), (10, 9), (10, 10)], cost=3)]
    return exercise("Hold & <b>it</b>").model_copy(update={"limits": limits})


def test_a_sheet_has_who_when_and_with_what_limits_and_acts_and_no_change_of_it_passes(tmp_path):
    fly_exercise(limited(), acting, tmp_path, person="Ada <L.>")
    path = tmp_path / "score.json"
    sheet = read_sheet(path)
    assert (sheet["person"], sheet["seed"], sheet["build"]) == ("Ada <L.>", 0, build_fingerprint())
    assert datetime.fromisoformat(sheet["date"]).tzinfo is not None
    assert [(each["title"], each["cost"], each["broken"]) for each in sheet["limits"]] == [
        ("No collision", 20.0, 0), ("Stay within the area", 3.0, 1)
    ]  # fmt: skip
    assert [act["text"].split(":")[0] for act in sheet["acts"]] == ["set lamp", "note"], "repeats are listed once"
    page, text = (tmp_path / "sheet.html").read_text(), (tmp_path / "sheet.txt").read_text()
    for shown in (sheet["date"], sheet["build"], sheet["digest"], "Stay within the area", "set lamp"):
        assert shown in page and shown in text
    assert "Ada &lt;L.&gt;" in page and "Ada <L.>" in text
    for key, value in sheet.items():
        if key != "digest":
            path.write_text(json.dumps({**sheet, key: [value]}))
            with pytest.raises(ValueError, match="has been changed since it was written"):
                read_sheet(path)
    assert "has been changed since it was written" in error_line(uwsim("exercise", "check", path))
    path.write_text(json.dumps(sheet, indent=4))
    assert read_sheet(path) == sheet, "the layout of the file does not count"
    assert "is as it was written: Ada <L.>, Hold" in uwsim("exercise", "check", path).stdout


def test_a_name_is_bounded_and_refused_before_the_flight(tmp_path):
    for person in (" ", "x" * (PERSON_MAX + 1), "a\nb"):
        with pytest.raises(ValueError, match="must have 1 to 80 printable characters"):
            fly_exercise(limited(), still, tmp_path, person=person)
    assert not list(tmp_path.iterdir())


def test_commands_are_bounded_and_another_pilot_spoils_the_score():
    conduct = Conduct([])
    for k in range(ACTS_MAX + 5):
        conduct.note_command(float(k), "hold", f"hold: {k}")
    assert len(conduct.listed()["acts"]) == ACTS_MAX and conduct.listed()["acts_omitted"] == 5
    assert conduct.invalid_because == ""
    assert len(conduct._last) <= ACTS_MAX, "what is remembered of repeats is bounded, too"
    conduct.note_pilot("Bob")
    assert conduct.invalid_because == "Bob had the controls, too"


def test_aiming_is_not_remembered_and_a_command_after_a_return_to_an_earlier_time_is_listed():
    conduct = Conduct([])
    for k in range(100):
        conduct.note_command(0.1 * k, "aim", f"aim: {k}")
    conduct.note_command(50.0, "hold", "hold: depth")
    conduct.note_command(20.0, "hold", "hold: depth")
    assert [act["time_s"] for act in conduct.listed()["acts"]] == [50.0, 20.0] and len(conduct._last) == 1


def test_a_sheet_without_a_person_is_refused_in_a_line(tmp_path):
    path = tmp_path / "score.json"
    path.write_text(json.dumps({"digest": digest_of({})}))
    with pytest.raises(ValueError, match="is not a score sheet"):
        read_sheet(path)


def test_full_ahead_ends_at_the_wall_and_costs():
    def ahead(vehicle):
        vehicle.set_effort(surge=1.0)
        yield wait(14.0)

    course = fly_exercise("hover", ahead).course
    x, y, _ = course.track[-1, 1:4]
    assert abs(x) < 12.5 and 9.0 < abs(y) < 10.0
    assert {each["title"]: each["broken"] for each in course.sheet()["limits"]}["Stay within the area"] == 1
    assert course.state()["lost"] >= 30.0
