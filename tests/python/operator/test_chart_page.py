"""The chart in a real browser: waypoints drawn, measured, saved as a mission's file, flown, and taken over by hand."""

import runpy

import numpy as np
import pytest

import uwsim
from browser import judge, shows, until, when

DRAWN = [(-3.0, 3.0), (2.0, 3.0), (2.0, -3.0)]


@pytest.fixture(scope="module")
def page(page):
    page.evaluate("station.views.enlarge('chart')")
    when(page, "station.chart.frame.scale > 5")
    return page


def click(page, place):
    x, y = page.evaluate("(place) => station.chart.frame.at(place)", list(place))
    box = page.locator(".view.is-large canvas").first.bounding_box()
    page.mouse.click(box["x"] + x, box["y"] + y)


def test_a_plan_is_drawn_saved_and_flown(here, page):
    page.click("text=Measure")
    click(page, DRAWN[0])
    click(page, DRAWN[1])
    shows(page, ".view.is-large .scene-note", "5.0 m, 090°")
    page.click("text=Waypoint")
    for place in DRAWN:
        click(page, place)
    drawn = np.array(page.evaluate("station.chart.points"))
    np.testing.assert_allclose(drawn[:, :2], DRAWN, atol=0.05)
    np.testing.assert_allclose(drawn[:, 2], -2.0)
    page.fill("[aria-label='Name of the plan']", "square")
    page.click(".chart-tools >> text=Save")
    path = here.station.sessions.folder / "square.py"
    until(path.exists, "the file")
    saved = runpy.run_path(str(path))
    np.testing.assert_allclose(saved["POINTS_WORLD_M"], drawn, atol=1e-3)

    live = here.station.present().live
    live.speed = 20.0
    page.click(".chart-tools >> text=Fly")
    when(page, "station.chart.state?.reached === 1")
    page.wait_for_timeout(300)
    judge(page, "chart")
    when(page, "station.chart.state?.is_flying === false")
    shows(page, ".view.is-large .scene-note", "all waypoints are reached")
    position = live.read(lambda sim: np.array(sim.rov.pose.position_world_m)).result()
    assert np.linalg.norm(position - drawn[-1]) < 1.0  # by its own estimate
    flown = uwsim.fly(path, "pool", report="none")
    assert [event.name for event in flown.events].count("waypoint") == 3 and not flown.ended_early
    assert np.linalg.norm(flown.samples["rov"].path_world_m[-1] - drawn[-1]) < 0.6


def test_a_key_takes_over_and_another_page_may_not_fly(here, page):
    if not page.evaluate("station.chart.points.length"):  # another process may have flown the test before
        page.click("text=Waypoint")
        for place in DRAWN:
            click(page, place)
    live = here.station.present().live
    live.speed = 1.0
    page.click(".chart-tools >> text=Fly")
    when(page, "station.chart.state?.is_flying === true")
    watcher = here.fly()
    said = watcher.evaluate("station.station.bridge.call('/station/plan', {action: 'stop'})")
    assert not said["success"] and "has the controls" in said["message"]
    watcher.context.close()
    page.locator("body").click(position={"x": 700, "y": 5})
    page.keyboard.down("s")
    when(page, "station.chart.state?.is_flying === false")
    shows(page, ".view.is-large .scene-note", "the pilot has the controls")
    until(lambda: here.effort("surge") == -0.5, "the pilot's effort")
    page.keyboard.up("s")
    until(lambda: not here.rov.effort.any(), "rest")
    assert not here.complaints


@pytest.mark.parametrize(
    ("args", "expected"),
    [
        ({"action": "fly", "vehicle": "rov", "points_m": []}, "1 to 200 points"),
        ({"action": "fly", "vehicle": "rov", "points_m": [[0, 0]]}, "three numbers"),
        ({"action": "fly", "vehicle": "rov", "points_m": [[0, 0, -1]], "speed_m_s": 9}, "speed_m_s = 9"),
        ({"action": "fly", "vehicle": "cow", "points_m": [[0, 0, -1]]}, "must be one of rov"),
        ({"action": "save", "points_m": [[0, 0, -1]], "name": "../x"}, "must have 1 to 64"),
        ({"action": "swim", "points_m": [[0, 0, -1]]}, "must be one of report"),
    ],
)
def test_wrong_plans_are_refused(page, args, expected):
    said = page.evaluate("(args) => station.station.bridge.call('/station/plan', args)", args)
    assert not said["success"] and expected in said["message"]
