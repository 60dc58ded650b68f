"""A debriefing film, made at the station of an attempt that has just ended: by a server, without a browser."""

import io
import json

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


def test_a_film_is_offered_when_an_attempt_has_ended_and_shows_all_of_it(tmp_path):
    with (
        serving(tmp_path, is_fixed=True, truth=False, keep_flights=Bounds(2)) as (station, server),
        page(server) as ada,
    ):
        station.run_exercise(Exercise.model_validate(SHORT))
        assert ada.call("take_control")["success"]
        assert "before the attempt has ended" in ada.call("control", action="film")["message"]
        assert ada.call("control", action="begin")["success"]
        assert ada.call("drive", vehicle="rov", surge=0.5)["success"]  # a flight without a command is not kept
        until(lambda: ada.call("exercise")["film"] == "offered", "the offer")
        assert "must be one of de, en" in ada.call("control", action="film", language="fr")["message"]
        assert get(server, "/exercise/debrief.webp")[0] == 404
        assert ada.call("control", action="restart")["success"]  # which ends the recording
        assert ada.call("control", action="film", language="de")["success"]
        assert not ada.call("control", action="film")["success"]
        state = until(lambda: (now := ada.call("exercise"))["film"] != "making" and now, "the film")
        assert (state["film"], state["error"]) == ("made", "")
        status, body, headers = get(server, "/exercise/debrief.webp")
        assert status == 200 and headers["Content-Type"] == "image/webp"
        flown_s = json.loads((tmp_path / "sheet-1/score.json").read_text())["time_s"]
        with Image.open(io.BytesIO(body)) as film:
            assert abs(film.n_frames - FPS * flown_s) <= 1
        assert ada.call("control", action="begin")["success"]
        assert ada.call("exercise")["film"] == ""
