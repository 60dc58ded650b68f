"""A sheet names person, date and build, and a changed one is noticed; the log book has each named person's attempts."""

import csv
import io
import json
import re
from datetime import datetime
from unittest.mock import Mock

import pytest

from command_line import uwsim
from test_sheet import exercise, still
from uwsim.cli.exit_codes import INCOMPLETE
from uwsim.exercises.certified import PERSON_MAX, certified_sheet, digest_of, read_sheet
from uwsim.exercises.conduct import ACTS_MAX, Conduct
from uwsim.exercises.exercise import Exercise
from uwsim.exercises.flight import fly_exercise
from uwsim.exercises.limits import Area, Collisions
from uwsim.exercises.logbook import log_attempt, read_book, totals
from uwsim.missions import wait
from uwsim.scenario.fingerprint import build_fingerprint


@pytest.fixture
def book(tmp_path, monkeypatch):
    path = tmp_path / "data" / "logbook.jsonl"
    monkeypatch.setenv("UWSIM_LOGBOOK", str(path))
    return path


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
    path.write_text(json.dumps(sheet, indent=4))
    assert read_sheet(path) == sheet, "the layout of the file does not count"


def test_the_log_book_keeps_each_attempt_of_a_named_person(tmp_path, book):
    for person in ("Ada", "", "Bob", "Ada"):
        fly_exercise(limited(), still, person=person)
    found = read_book(book).entries
    assert [each.person for each in found] == ["Ada", "Bob", "Ada"]
    assert totals(found)["Ada"] == {
        "exercises": 1,
        "passed": 1,
        "attempts": 2,
        "hours": pytest.approx(2 * 1.0 / 3600.0),
    }
    printed = uwsim("exercise", "logbook", "--csv", "--person", "Ada")
    assert [row["person"] for row in csv.DictReader(io.StringIO(printed.stdout))] == ["Ada", "Ada"]
    assert [each["person"] for each in json.loads(uwsim("exercise", "logbook", "--json").stdout)] == [
        "Ada",
        "Bob",
        "Ada",
    ]
    assert "1 of 1 exercises passed in 2 attempts  Ada" in uwsim("exercise", "logbook").stdout


def test_a_line_that_was_cut_short_spoils_no_later_one_and_a_strangers_file_stays_as_it_is(book):
    fly_exercise(limited(), still, person="Ada")
    with book.open("ab") as file:
        file.write(b'{"date": "2026')
    fly_exercise(limited(), still, person="Bob")
    assert len(book.read_text().splitlines()) == 3
    found = read_book(book)
    assert [each.person for each in found.entries] == ["Ada", "Bob"] and found.unread == [2]
    printed = uwsim("exercise", "logbook", "--json")
    assert printed.returncode == INCOMPLETE and [each["person"] for each in json.loads(printed.stdout)] == [
        "Ada",
        "Bob",
    ]
    assert "line 2: is not an entry of a log book" in printed.stderr and "Traceback" not in printed.stderr
    book.write_text("my notes\n")
    with pytest.raises(ValueError, match="line 1: is not an entry"):
        fly_exercise(limited(), still, person="Ada")
    assert book.read_text() == "my notes\n"
    failed = uwsim("exercise", "logbook")
    assert failed.returncode == 1 and "line 1: is not an entry" in failed.stderr and "Traceback" not in failed.stderr


pytestmark = pytest.mark.usefixtures("blank_figures")
PEOPLE = ("Ada", "Bob", "Eve", "Dan")


@pytest.fixture(scope="module")
def sheet():
    return certified_sheet(fly_exercise(limited(), still).course, "Ada")


@pytest.fixture
def lines(book, sheet):
    """The lines of a book of four attempts, one of each person."""
    for person in PEOPLE:
        log_attempt({**sheet, "person": person})
    return book.read_bytes().splitlines()


def raised(line: bytes) -> bytes:
    found, count = re.subn(rb'"score":[^,]+', b'"score":9.75', line)
    assert found != line and count == 1
    return found


def sealed_again(line: bytes) -> bytes:
    values = json.loads(raised(line))
    return json.dumps({**values, "line_digest": digest_of(values, "line_digest")}).encode()


def unsealed(line: bytes) -> bytes:
    values = json.loads(raised(line))
    return json.dumps({key: values[key] for key in values if key not in ("previous", "line_digest")}).encode()


SPOILS = {
    "a score": (lambda a, b, c, d: [a, raised(b), c, d], [2]),
    "the last score": (lambda a, b, c, d: [a, b, c, raised(d)], [4]),
    "an added value": (lambda a, b, c, d: [a, b, c[:-1] + b', "note": 1}', d], [3]),
    "a score and its digest": (lambda a, b, c, d: [a, sealed_again(b), c, d], [2]),
    "the first without its digest": (lambda a, b, c, d: [unsealed(a), b, c, d], [1]),
    "the last without its digest": (lambda a, b, c, d: [a, b, c, unsealed(d)], [4]),
    "one removed": (lambda a, b, c, d: [a, c, d], [1]),
    "the first removed": (lambda a, b, c, d: [b, c, d], [1]),
    "one twice": (lambda a, b, c, d: [a, b, b, c, d], [2]),
    "two exchanged": (lambda a, b, c, d: [a, c, b, d], [1, 2, 3]),
}


def test_a_line_that_is_not_as_it_was_written_is_shown_as_not_valid_and_counts_for_no_person(book, lines):
    assert [line.check for line in read_book(book).lines] == ["valid"] * 4
    for spoil, wrong in SPOILS.values():
        book.write_bytes(b"\n".join(spoil(*lines)) + b"\n")
        found = read_book(book)
        assert [line.number for line in found.lines if line.check == "not valid"] == wrong and not found.unread
        printed = uwsim("exercise", "logbook")
        assert printed.returncode == INCOMPLETE and f"{len(wrong)} not valid" in printed.stdout
        assert [f"line {k}: is not valid: " in printed.stderr for k in wrong] == [True] * len(wrong)
        counted = [line.entry.person for line in found.lines if line.check == "valid"]
        assert sorted(row.split()[-1] for row in printed.stdout.splitlines()[:-1]) == sorted(set(counted))
        person = found.lines[wrong[0] - 1].entry.person
        shown = uwsim("exercise", "logbook", "--person", person).stdout.splitlines()
        assert any(f"not valid: line {wrong[0]} of the log book" in line for line in shown)


def test_a_book_cut_short_at_any_byte_keeps_its_other_lines_and_takes_new_ones(book, lines, sheet):
    first, second = (line + b"\n" for line in lines[:2])
    for end in (*range(1, len(first) + 1, 13), len(first) - 1, len(first)):
        for before in (b"", first):
            kept = before + (second if before else first)[:end]
            book.write_bytes(kept)
            read_book(book)
            log_attempt(sheet)
            log_attempt(sheet)
            found = read_book(book)
            assert book.read_bytes().startswith(kept)
            assert {line.check for line in found.lines} == {"valid"} and len(found.unread) <= 1
            assert len(found.lines) + len(found.unread) == (4 if before else 3)


def test_an_attempt_is_in_the_log_book_also_if_its_sheet_cannot_be_written(tmp_path, book, monkeypatch):
    monkeypatch.setattr("uwsim.exercises.sheet.sheet_html", Mock(side_effect=OSError("no space")))
    with pytest.raises(OSError, match="no space"):
        fly_exercise(limited(), still, tmp_path, person="Ada")
    assert [each.person for each in read_book(book).entries] == ["Ada"]


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
