"""An exercise at the station: a person flies it in a real browser, sees the score, and loads the sheet."""

import json
from pathlib import Path

import pytest

from browser import Desk, chromium, until, when
from test_station_page import judge
from uwsim.bridges import RosbridgeServer
from uwsim.exercises import load_exercise
from uwsim.operator.station import Site, Station


@pytest.fixture(scope="module")
def here(tmp_path_factory):
    folder = tmp_path_factory.mktemp("exercise")
    station = Station(is_fixed=True, truth=False, folder=folder)
    short = load_exercise("hover").model_copy(update={"time_s": 30.0})
    with (
        chromium() as browser,
        RosbridgeServer(None, guests=[station], site=Site(station)) as server,
        station.serving(server.show),
    ):
        station.run_exercise(short)
        yield Desk(browser, station, server)
        for context in list(browser.contexts):
            context.close()


def test_the_score_follows_the_flight_and_the_sheet_comes_at_the_end(here, tmp_path: Path):
    page = here.fly(viewport={"width": 1440, "height": 900})
    live = here.station.present().live
    when(page, "document.querySelector('#exercise') && !document.querySelector('#exercise').hidden")
    until(lambda: "0 of 100 points" in page.inner_text("#exercise"), "the score")
    live.command("place", vehicle="rov", position_world_m=[0.0, 0.0, -2.5]).result()
    until(lambda: "20 / 20" in page.inner_text("#exercise"), "the first goal")
    judge(page, "exercise")
    page.screenshot(path=tmp_path / "under-way.png")
    live.speed = 20.0
    page.wait_for_selector("#exercise >> text=Not passed: the time is over")
    page.wait_for_selector(".exercise-sheet:not([hidden])")
    with page.expect_download() as loaded:
        page.click(".exercise-sheet")
    assert "<h1>Hover</h1>" in Path(loaded.value.path()).read_text()
    score = json.loads((here.station.folder / "sheet-1/score.json").read_text())
    assert score["goals"][0]["share"] == 1.0 and not score["has_passed"]
    page.screenshot(path=tmp_path / "over.png")
    here.station.present().live.reset()
    until(
        lambda: "left" in page.inner_text("#exercise") and "Not passed" not in page.inner_text("#exercise"), "a restart"
    )
    assert not here.complaints
