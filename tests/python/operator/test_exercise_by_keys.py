"""A whole exercise by keys alone, on a German page, whose acts are counted; axe before and after it."""

import numpy as np

from browser import exercise_desk, judge, shows, until, when
from uwsim.exercises import Exercise
from uwsim.operator.station.flights.flights import Bounds

MOST_ACTS = 3
TURN = {
    "title": "Durch und herum", "brief": "Fahren Sie nach Osten, dann drehen Sie sich nach Norden.", "scenario": "pool",
    "start": {"position_m": [-3, 0, -2], "yaw_deg": 0}, "time_s": 120, "pass_points": 20,
    "goals": [
        {"kind": "pass", "name": "on", "title": "Nach Osten", "position_m": [-2, 0, -2], "heading_deg": 0},
        {"kind": "hold", "name": "north", "title": "Nach Norden", "after": "on", "heading_deg": 90, "within_deg": 40,
         "for_s": 0.5, "points": 10},
    ],
}  # fmt: skip


def test_an_exercise_is_flown_by_keys_alone_on_a_page_without_faults_of_access(browser, tmp_path):
    with exercise_desk(browser, tmp_path, Exercise.model_validate(TURN), keep_flights=Bounds(2)) as here:
        page = here.fly(locale="de-DE", viewport={"width": 1440, "height": 900})
        live, acts = here.station.present().live, []

        def press(key: str, until_met=lambda: True) -> None:
            acts.append(key)
            page.keyboard.down(key)
            until(until_met, key, 25.0)
            page.keyboard.up(key)

        def pose():
            return live.read(lambda sim: sim.rov.pose).result()

        shows(page, "#exercise", "Die Zeit steht")
        judge(page, "waiting", "#exercise")
        press("Enter")
        until(lambda: live.tick > 0, "time")
        press("KeyW", lambda: pose().position_world_m[0] > -2.0)
        shows(page, "#exercise", "10 / 10", 30.0)
        press("KeyQ", lambda: np.degrees(pose().yaw_rad) > 60.0)
        when(page, "document.querySelector('.exercise-after:not([hidden])')", 30.0)
        judge(page, "over")
        page.click("text=Film zur Nachbesprechung machen")
        shows(page, ".film-make:disabled", "Film: ")
        judge(page, "filming", "#exercise")
        shows(page, "#exercise", "20 von 20", 30.0)
        assert len(acts) <= MOST_ACTS
        assert here.rov.collisions == 0 and not here.complaints
