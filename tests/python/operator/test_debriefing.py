"""Debriefing films, made at the station of an attempt that was recorded: by a server, without a browser."""

import io
import json
import shutil

from PIL import Image

from station_pages import get, page, serving
from uwsim.exercises import Exercise
from uwsim.exercises.debrief import FPS
from uwsim.operator.station.flights.flights import Bounds
from waiting import until

SHORT = {
    "title": "Be there", "brief": "Stay.", "scenario": "pool", "time_s": 2.0, "pass_points": 5,
    "start": {"position_m": [0, 0, -2.0]},
    "goals": [{"kind": "reach", "name": "far", "title": "Be there", "position_m": [9, 0, -2], "points": 10}],
}  # fmt: skip


def test_a_film_of_an_attempt_is_offered_at_its_end_and_wherever_its_flight_is_chosen(tmp_path):
    with serving(tmp_path, keep_flights=Bounds(2)) as (station, server), page(server) as ada:
        station.run_exercise(Exercise.model_validate(SHORT))
        assert ada.call("take_control")["success"]
        assert ada.call("exercise")["flight"] == ""
        assert ada.call("control", action="begin")["success"]
        assert ada.call("drive", vehicle="rov", surge=0.5)["success"]  # a flight without a command is not kept
        flight = until(lambda: ada.call("exercise")["flight"], "the offer")
        assert ada.call("film", flight=flight)["film"] == "offered"
        assert "must be one of de, en" in ada.call("film", flight=flight, language="fr")["message"]
        with page(server) as ben:
            assert "control" in ben.call("film", flight=flight, language="en")["message"]
        assert get(server, f"/film/{flight}.webp")[0] == 404
        assert ada.call("control", action="restart")["success"]  # which ends the recording
        assert ada.call("control", action="begin")["success"]
        assert ada.call("exercise")["flight"] == ""
        assert ada.call("control", action="quit")["success"]
        shutil.copy(tmp_path / "flights" / flight, tmp_path / "flights/other.mcap")
        other, listed = sorted(ada.call("catalog")["flights"], key=lambda each: each["name"] == flight)
        assert (listed["film"], listed["exercise"], other["film"]) == ("offered", SHORT["title"], "")
        assert "an attempt that has ended" in ada.call("film", flight="other.mcap", language="de")["message"]
        assert ada.call("start", flight=flight, speed=1)["success"]
        assert ada.call("film", flight=flight, language="de")["film"] == "making"
        assert "being made" in ada.call("film", flight=flight, language="en")["message"]
        state = until(lambda: (now := ada.call("film", flight=flight))["film"] != "making" and now, "the film")
        assert (state["film"], state["film_trouble"]) == ("made", "")
        status, body, headers = get(server, f"/film/{flight}.webp")
        assert status == 200 and headers["Content-Type"] == "image/webp"
        flown_s = json.loads((tmp_path / "sheet-1/score.json").read_text())["time_s"]
        with Image.open(io.BytesIO(body)) as film:
            assert abs(film.n_frames - FPS * flown_s) <= 1
