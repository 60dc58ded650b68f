"""Inspection in a real browser: a video, snapshots that carry their values, notes on the chart."""

import csv
import io
import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from browser import judge, until, when

START_M = [2.0, 1.0, -2.0]


def frames(path):
    video = cv2.VideoCapture(str(path))
    while True:
        is_read, frame = video.read()
        if not is_read:
            return
        yield cv2.cvtColor(frame, cv2.COLOR_BGR2RGB)


def snapshot(page):
    with page.expect_download() as saved:
        page.click("#snapshot")
    picture = Image.open(io.BytesIO(Path(saved.value.path()).read_bytes()))
    picture.load()
    return picture.size, picture.text


def comment(page) -> None:
    """Comment by keys, unless an earlier test has done so."""
    if page.evaluate("station.station.state.comment") != "Weld 12, süd":
        page.keyboard.press("Backquote")
        page.keyboard.type("Weld 12, süd")
        page.keyboard.press("Enter")
        when(page, "station.station.state.comment === 'Weld 12, süd'")
        assert page.evaluate("document.activeElement === document.body")  # the keys drive again


def test_a_video_shows_the_large_view(page):
    with page.expect_download() as saved:
        page.click("#record")
        page.wait_for_timeout(2500)
        page.click("#record")
    found = list(frames(saved.value.path()))
    assert saved.value.suggested_filename.startswith("pool-run-") and len(found) > 3
    assert found[0].shape == (540, 960, 3) and found[-1].std() > 5.0


def test_snapshots_carry_the_instruments_values(here, page):
    comment(page)
    page.evaluate("station.views.enlarge('front')")
    size, text = snapshot(page)
    values = json.loads(text["uwsim"])
    assert size == (640, 360) and values["comment"] == text["Comment"] == "Weld 12, süd"
    depth_m = here.rov.sensors["depth"].read()
    assert values["depth_m"] == pytest.approx(depth_m, abs=0.2)
    np.testing.assert_allclose(values["position_m"], [2.0, 1.0, -2.0], atol=0.5)
    page.evaluate("station.views.enlarge('chart')")
    page.wait_for_timeout(100)
    size, text = snapshot(page)  # by the page itself, which has no values in it
    assert size[0] > 640 and not text


def test_notes_stand_on_the_chart_and_in_files_and_a_watcher_writes_none(here, page):
    comment(page)
    page.evaluate("station.views.enlarge('front')")
    page.select_option("[aria-label='Category of the note']", "defect")
    page.select_option("[aria-label='Place of the note']", "vehicle")
    page.fill("#note-text", "Crack <b>in</b> the weld")
    page.click("#add-note")
    when(page, "station.inspection.notes.length === 1")
    here.station.present().live.command("place", vehicle="rov", position_world_m=[-2.0, 1.0, -2.0]).result()
    when(page, "station.telemetry.message.position[0] < -1")
    page.select_option("[aria-label='Category of the note']", "debris")
    page.click("body", position={"x": 700, "y": 5})
    page.keyboard.press("m")
    when(page, "station.inspection.notes.length === 2")
    when(page, "document.querySelectorAll('.notes li').length === 2")
    items = page.locator(".notes li").all_inner_texts()
    assert "2. Debris" in items[0] and "1. Defect: Crack <b>in</b> the weld" in items[1]
    first = page.evaluate("station.inspection.notes[0]")
    np.testing.assert_allclose(first["position_m"], [2.0, 1.0, -2.0], atol=0.5)
    assert (here.station.sessions.folder / first["picture"]).is_file()
    when(page, "station.scene.marks.count === 2")
    judge(page, "inspection")
    page.evaluate("station.views.enlarge('chart')")
    when(page, "station.chart.frame.scale > 5")

    # Between the pin's tip and its number, whose white edge reaches almost to the pin's. Computed each time, since the
    # frame may change once more after the chart has been enlarged.
    def pin():
        return page.evaluate(
            """() => { const canvas = station.chart.canvas, ratio = canvas.width / canvas.clientWidth;
            const [x, y] = station.chart.frame.at(station.inspection.notes[0].position_m);
            return [...canvas.getContext('2d').getImageData(x * ratio, (y - 6) * ratio, 1, 1).data]; }"""
        )

    until(lambda: np.abs(np.subtract(pin()[:3], [255, 122, 102])).max() < 30, "the colour of defects")
    with page.expect_download() as loaded:
        page.click("[aria-label='Notes as .csv']")
    rows = list(csv.DictReader(Path(loaded.value.path()).read_text().splitlines()))
    assert [row["category"] for row in rows] == ["comment", "defect", "debris"]
    watcher = here.fly()
    when(watcher, "station.inspection.notes.length === 2")
    when(watcher, "document.querySelector('#comment').value === 'Weld 12, süd'")
    assert watcher.is_disabled("#comment") and watcher.is_disabled("#add-note")
    watcher.context.close()
