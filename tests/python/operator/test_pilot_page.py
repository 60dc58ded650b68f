"""Holds, display and warnings as the pilot sees them, in a real browser: one station and one page for all of it."""

from pathlib import Path

import pytest

from browser import chromium, desk, until, when
from test_station_page import judge


@pytest.fixture(scope="module")
def here(tmp_path_factory):
    with chromium() as browser, desk(browser, tmp_path_factory.mktemp("pilot"), "pool") as found:
        found.station.present().live.rov.undock()
        yield found


@pytest.fixture(scope="module")
def page(here):
    page = here.fly(viewport={"width": 1440, "height": 900})
    when(page, "station.station.isPilot")
    return page


@pytest.fixture(autouse=True)
def nothing_complains(here):
    yield
    assert not here.complaints


def test_keys_and_buttons_hold_and_a_lost_sensor_is_shown(here, page, tmp_path: Path):
    live, holds = here.station.present().live, here.rov.holds
    page.keyboard.press("h")
    page.keyboard.press("z")
    until(lambda: set(holds.targets) == {"heading", "depth"} and all(holds.targets.values()), "two holds")
    page.wait_for_selector("#hold-heading[aria-pressed=true]")
    judge(page, "holds")
    page.screenshot(path=tmp_path / "holds.png")
    page.evaluate("station.pilot.answers_ms = []")
    page.click("#hold-speed")
    until(lambda: "speed" in holds.targets, "a speed hold")
    when(page, "station.pilot.answers_ms.length > 2 && !station.pilot.isHeld")  # it sends zeros, by which it is known
    page.click("#help")
    until(lambda: set(holds.targets) == {"heading", "depth"}, "the end of the speed hold behind a dialog")
    page.keyboard.press("Escape")
    live.command("inject_fault", kind="sensor", sensor="depth", mode="off", name="no_depth").result()
    when(page, "station.telemetry.message.hold_note.includes('depth hold ended')")
    page.wait_for_selector("#hold-depth[aria-pressed=false]")
    page.screenshot(path=tmp_path / "lost.png")
    live.command("end_fault", name="no_depth").result()
    page.click("#hold-heading")
    until(lambda: not holds.targets, "no hold")
