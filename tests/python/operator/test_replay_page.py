"""Replay in a real browser: fly, find the flight, scrub, look elsewhere, take the helm."""

import errno
import os
import shutil
from pathlib import Path

import numpy as np

from browser import desk, judge, shows, until, when
from flown import fly
from uwsim.operator.station.flights.flights import Bounds
from uwsim.recording import Recording
from uwsim.recording.mcap_sink import McapSink

KEEP = Bounds(10)


def slide_to(slider, time_s: float) -> None:
    slider.evaluate("(slider, to) => { slider.value = to; slider.dispatchEvent(new Event('input')); }", time_s)


def test_the_lamp_is_red_when_the_flight_is_not_recorded(browser, tmp_path: Path, monkeypatch):
    with desk(browser, tmp_path, keep_flights=KEEP) as here:
        page = here.open()
        page.wait_for_selector("#field-scenario")
        page.click("button[type=submit]")
        when(page, "station.station.isPilot && station.telemetry.message")
        page.keyboard.press("y")
        until(lambda: here.rov.released, "the vehicle in free water")
        page.wait_for_selector("#rec:not(.is-off) >> text=/^REC$/")
        (path,) = (tmp_path / "flights").iterdir()
        assert path.name in page.get_attribute("#rec", "title")
        green = page.evaluate("getComputedStyle(document.getElementById('rec')).backgroundColor")
        until(lambda: Recording(path).end_tick is not None, "a chunk")

        def full(*arguments):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

        monkeypatch.setattr(McapSink, "write", full)
        page.wait_for_selector("#rec.is-off >> text=NO REC")
        assert "No space left on device" in page.get_attribute("#rec", "title")
        assert page.evaluate("getComputedStyle(document.getElementById('rec')).backgroundColor") != green
        judge(page, "a flight that is not recorded")
        monkeypatch.undo()
        page.keyboard.press("Escape")
        page.click("text=Quit to the start screen")
        page.wait_for_selector("#flights li button:not(:disabled)")
        shows(page, "#flights li", "cut off at 0:")
        page.click("#flights li button")
        page.wait_for_selector("#timeline:not([hidden])")
        assert page.is_hidden("#rec")  # a replay is not recorded, and need not be


def test_a_flight_is_found_scrubbed_and_flown_on(browser, tmp_path: Path):
    with desk(browser, tmp_path, keep_flights=KEEP) as here:
        page = here.open(viewport={"width": 1440, "height": 900})
        page.wait_for_selector("#field-scenario")
        assert page.is_hidden("#flights")
        page.fill("#field-seed", "7")
        page.click("button[type=submit]")
        when(page, "station.station.isPilot && station.telemetry.message")
        page.keyboard.press("y")
        until(lambda: here.rov.released, "the vehicle in free water")
        page.keyboard.down("w")
        live = here.station.present().live
        until(lambda: here.effort("surge") == 0.5, "an effort")
        begun = live.tick
        until(lambda: live.tick > begun + 500, "two and a half seconds of flight")
        page.keyboard.up("w")
        flown_to = live.read(lambda sim: np.array(sim.rov.pose.position_world_m)).result()
        page.keyboard.press("Escape")
        page.click("text=Quit to the start screen")
        page.wait_for_selector("#flights li button:not(:disabled)")
        judge(page, "start screen with a flight")

        page.click("#flights li button")
        page.wait_for_selector("#timeline:not([hidden])")
        when(page, "station.station.isPilot && station.telemetry.message")
        shows(page, "#lease", "set the time")
        assert page.is_hidden("#all-stop") and page.is_hidden("#dock")
        live, replay = here.station.present().live, here.station.present().replay
        until(lambda: live.paused and live.tick == replay.timeline.end_tick, "the end")
        end = live.read(lambda sim: np.array(sim.rov.pose.position_world_m)).result()
        assert np.linalg.norm(end - flown_to) < 1.0  # until the menu paused the flight
        page.keyboard.down("w")  # a replay cannot be driven
        page.wait_for_selector("#hint >> text=Take the helm to fly")
        page.keyboard.up("w")
        assert np.array_equal(end, live.read(lambda sim: np.array(sim.rov.pose.position_world_m)).result())

        slider = page.locator("#timeline input[type=range]")
        slide_to(slider, 1.0)
        until(lambda: live.tick == 200, "one second")
        when(page, "Math.abs(station.telemetry.stamp_s - 1) < 0.2")
        slider.focus()
        page.keyboard.press("ArrowRight")
        until(lambda: live.tick == 210, "one step of the slider")
        page.locator("#timeline .timeline-plot").click(position={"x": 8, "y": 10})
        until(lambda: live.tick == replay.timeline.start_tick, "the start")
        label = page.locator("select[aria-label='Go to an event'] option").all_inner_texts()
        assert any("Undock" in text for text in label)
        page.select_option("select[aria-label='Go to an event']", index=1)
        until(lambda: abs(live.tick - 200 * replay.timeline.events[0].time_s) <= 1, "the first event")

        chase = page.evaluate(
            "station.views.names.find((name) => name.includes('chase')) ?? station.views.names.at(-1)"
        )
        page.evaluate("(name) => station.views.enlarge(name)", chase)
        pushed = next(each.tick for each in replay.timeline.commands if each.arguments.get("surge"))
        helm_tick = 10 * (pushed // 10 + 8)  # while the first pilot drives ahead; a whole step of the slider
        slide_to(slider, helm_tick / 200)
        until(lambda: live.tick == helm_tick, "the moment after the first effort")
        when(page, f"station.views.picture('{chase}').drawn > 0")  # a camera that was not shown in flight
        judge(page, "replay")

        page.click("text=Take the helm")
        page.wait_for_selector("#timeline", state="hidden")
        when(page, "station.station.description?.branched_from && station.station.isPilot && station.telemetry.message")
        live = here.station.present().live
        assert live.paused and live.tick == helm_tick and not page.is_hidden("#all-stop")
        page.click("#pause")
        page.keyboard.down("s")  # back, which differs from the first flight even if its page was silent for a while
        until(lambda: here.effort("surge") == -0.5, "another effort")
        until(lambda: live.tick > helm_tick + 500, "another flight")
        page.keyboard.up("s")
        page.keyboard.press("Escape")
        page.click("text=Quit to the start screen")
        when(page, "document.querySelectorAll('#flights li').length === 2")
        assert "flown on from" in page.locator("#flights li").first.inner_text()
        assert not here.complaints


def test_a_flight_that_was_cut_is_refused_in_one_line_and_a_restarted_server_lists_the_others(browser, tmp_path: Path):
    folder = tmp_path / "flights"
    folder.mkdir()
    whole = fly(folder / "20260102-000000-pool.mcap", end_s=2.0).read_bytes()
    (folder / "20260103-000000-pool.mcap").write_bytes(whole[: len(whole) // 10])  # in its first chunk
    flipped = bytearray(whole)
    flipped[len(whole) // 2] ^= 1
    (folder / "20260104-000000-pool.mcap").write_bytes(flipped)
    for _ in range(2):
        with desk(browser, tmp_path, keep_flights=KEEP) as here:
            page = here.open(color_scheme="light")
            when(page, "document.querySelectorAll('#flights li').length === 3")
            cut = page.locator("[data-flight^='20260103']")
            assert "is cut off" in cut.inner_text() and cut.locator("button").is_disabled()
            edited = page.locator("[data-flight^='20260104']")
            edited.locator("button").click()
            shows(page, "[data-flight^='20260104']", "damaged")
            assert page.is_visible("#start")
            judge(page, "refused flights")
            assert not here.complaints
    shutil.rmtree(folder)
