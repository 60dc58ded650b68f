"""A newcomer's three tasks, all from the page: fly to the pipeline without a collision, save the map, replay it."""

import re
import time
from collections import Counter
from pathlib import Path

import numpy as np

from browser import desk, shows, until, when
from uwsim.mapping import OccupancyMap
from uwsim.operator.station.flights.flights import Bounds

PIPELINE = (-100.0, -30.0)  # a corner of lake's pipeline_main; the chart shows its name there
NEAR_M = (-55.0, -15.0, -2.0)
ABOVE_M = 5.0
MOST_ACTS = {"pipeline": 11, "map": 1, "replay": 3}
FLIGHT_S = 300.0  # of simulated time, for a flight of about a minute


class Acts:
    """Acts of a newcomer at the page, counted by task."""

    def __init__(self, page) -> None:
        self.page, self.done = page, Counter[str]()

    def __call__(self, task: str, act: str, *given: object) -> None:
        self.done[task] += 1
        getattr(self.page, act)(*given)


def test_a_newcomer_flies_to_the_pipeline_saves_the_map_and_replays_the_run(browser, tmp_path: Path):
    with desk(browser, tmp_path, keep_flights=Bounds(10)) as here:
        page = here.open(viewport={"width": 1440, "height": 900})
        does = Acts(page)
        page.wait_for_selector("#field-scenario")
        does("pipeline", "select_option", "#field-scenario", "lake")
        does("pipeline", "click", "button[type=submit]")
        when(page, "station.station.isPilot && station.telemetry.message")
        does("pipeline", "click", "text=Undock")
        until(lambda: here.rov.released, "the vehicle in free water")
        page.select_option("#speed", "10")  # to shorten the test, as does a place nearer to the pipeline
        here.station.present().live.command("place", vehicle="rov", position_world_m=NEAR_M).result()

        does("pipeline", "click", ".swap[aria-label*=Chart]")
        when(page, "station.views.large === 'chart' && station.chart.flown.length > 0")
        box = page.locator(".view.is-large canvas").first.bounding_box()
        page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        shows(page, ".view.is-large .scene-note", "deep")  # the bed is there, to which the chart is fitted
        x, y = page.evaluate("(place) => station.chart.frame.at(place)", list(PIPELINE))
        page.mouse.move(box["x"] + x, box["y"] + y)
        bed_m = float(re.search(r"([\d.]+) m deep", page.inner_text(".view.is-large .scene-note"))[1])
        does("pipeline", "click", "text=Waypoint")
        for depth_m in (10.0, bed_m - ABOVE_M):
            does("pipeline", "fill", "[aria-label='Depth of waypoints [m]']", str(depth_m))
            page.mouse.click(box["x"] + x, box["y"] + y)
            does.done["pipeline"] += 1
        does("pipeline", "fill", "[aria-label='Speed [m/s]']", "1.5")
        does("pipeline", "click", ".chart-tools >> text=Fly")
        live = here.station.present().live
        last_ns = live.time_ns + 1e9 * FLIGHT_S
        while "all waypoints are reached" not in page.inner_text(".view.is-large .scene-note"):
            assert live.time_ns < last_ns, page.inner_text(".view.is-large .scene-note")
            time.sleep(0.1)
        there = live.read(lambda sim: np.array(sim.rov.pose.position_world_m)).result()
        assert np.linalg.norm(there[:2] - PIPELINE) < 4.0 and abs(there[2] + bed_m - ABOVE_M) < 2.0
        assert page.evaluate("station.telemetry.message.collisions") == 0

        with page.expect_download() as download:
            does("map", "click", "text=.bt")
        download.value.save_as(tmp_path / "map.bt")
        seen = OccupancyMap.read(tmp_path / "map.bt").occupied_voxels()
        assert np.linalg.norm(seen[:, :2] - PIPELINE, axis=1).min() < 1.0

        does("replay", "press", "body", "Escape")
        does("replay", "click", "text=Quit to the start screen")
        page.wait_for_selector("#flights li button:not(:disabled)")
        does("replay", "click", "#flights li button")
        page.wait_for_selector("#timeline:not([hidden])")
        live, timeline = here.station.present().live, here.station.present().replay.timeline
        slider = page.locator("#timeline input[type=range]")
        slider.focus()
        page.keyboard.press("End")
        until(lambda: live.paused and live.tick == timeline.end_tick, "the end of the replay")
        again = live.read(lambda sim: np.array(sim.rov.pose.position_world_m)).result()
        assert np.linalg.norm(again - there) < 3.0  # it hovered until the menu paused the flight
        assert all(does.done[task] <= most for task, most in MOST_ACTS.items()), does.done
        assert not here.complaints
