"""An exercise at the station: a person flies it in a real browser, begins, sees the score, and loads the sheet."""

import json
from pathlib import Path

import pytest

from browser import exercise_desk, judge, shows, until, when
from uwsim.exercises import load_exercise

NOT_VALID = "Not valid: the world was changed by the program that runs the simulator"


@pytest.fixture(scope="module")
def here(browser, tmp_path_factory):
    short = load_exercise("hover").model_copy(update={"time_s": 30.0})
    with exercise_desk(browser, tmp_path_factory.mktemp("exercise"), short) as found:
        yield found


@pytest.fixture(scope="module")
def page(here):
    return here.fly(viewport={"width": 1440, "height": 900})


def test_time_stands_still_until_the_pilot_presses_begin(here, page):
    live = here.station.present().live
    shows(page, "#exercise", "Time stands still until you begin.")
    shows(page, "#exercise", "0 of 100 points")
    page.keyboard.press("KeyW")
    shows(page, "#hint", "press Begin")
    judge(page, "waiting")
    assert live.paused and live.tick == 0
    assert all(page.is_hidden(f"#{each}") for each in ("pause", "speed", "step", "inspect"))
    page.click(".exercise-begin")
    until(lambda: live.tick > 0, "time")
    when(page, "!station.station.state.paused")
    page.wait_for_selector(".exercise-begin", state="hidden")


def test_an_aid_that_the_exercise_does_not_allow_is_refused_and_the_reason_shown(here, page):
    shows(page, "#exercise", "No aids are allowed.")
    page.click("#hold-depth")
    shows(page, "#toast", "hold: refused: the exercise does not allow this aid")
    holds = here.rov.holds
    assert holds is not None and not holds.has_control


def test_a_restart_leaves_a_sheet_and_waits_for_begin(here, page):
    live = here.station.present().live
    page.click("#menu")
    page.click("text=Restart from the beginning")
    until(lambda: live.paused and live.tick == 0, "a restart")
    until(lambda: (here.station.sessions.folder / "sheet-1/sheet.html").is_file(), "the broken-off attempt's sheet")
    score = json.loads((here.station.sessions.folder / "sheet-1/score.json").read_text())
    assert score["ended_because"] == "broken off: the exercise was restarted"
    assert score["attempt"] == 1 and score["time_s"] > 0 and score["is_valid"] and not score["has_passed"]
    shows(page, "#exercise", "Time stands still until you begin.")


def test_a_changed_world_makes_the_score_not_valid_and_the_sheet_says_so(here, page):
    live = here.station.present().live
    page.click(".exercise-begin")
    until(lambda: live.tick > 0, "time")
    with live.privileged():
        live.command("place", vehicle="rov", position_world_m=[0.0, 0.0, -2.5]).result()
    shows(page, "#exercise", "20 / 20")
    shows(page, "#exercise", NOT_VALID)
    judge(page, "exercise")
    with live.privileged():
        live.speed = 20.0
    page.wait_for_selector("#exercise >> text=Ended: the time is over")
    page.wait_for_selector(".exercise-sheet:not([hidden])")
    with page.expect_download() as loaded:
        page.click(".exercise-sheet")
    sheet = Path(loaded.value.path()).read_text()
    assert "<h1>Hover</h1>" in sheet and NOT_VALID in sheet and "place: " in sheet
    score = json.loads((here.station.sessions.folder / "sheet-2/score.json").read_text())
    assert score["attempt"] == 2 and not score["is_valid"] and not score["has_passed"]
    assert score["goals"][0]["share"] == 1.0
    judge(page, "over", "#exercise")
    page.click("#exercise >> text=Again")
    shows(page, "#exercise", "Time stands still until you begin.")
    assert [act["changed"] for act in score["outside_acts"]] == [True]


def test_a_jump_in_time_ends_an_attempt_too(here, page):
    live = here.station.present().live
    with live.privileged():
        live.reset()
    shows(page, "#exercise", "Time stands still until you begin.")
    page.click(".exercise-begin")
    until(lambda: live.tick > 20, "time")
    with live.privileged():
        live.reset()
    until(lambda: (here.station.sessions.folder / "sheet-3/score.json").is_file(), "a sheet")
    score = json.loads((here.station.sessions.folder / "sheet-3/score.json").read_text())
    assert score["ended_because"] == "broken off: time was set back" and score["time_s"] > 0
    until(lambda: live.paused, "rest")
    assert not here.complaints
