"""Notes and comments: where a note is placed, what its picture and files say, and how a recording holds it."""

import csv
import io
import json
import math

import numpy as np
import pytest
from PIL import Image

import uwsim
from station_pages import get, page, serving
from uwsim.base.quaternions import about_y, about_z, product
from uwsim.exercises import load_exercise
from uwsim.live import LiveSimulator
from uwsim.operator.station.sessions.inspection import looked_at, notes_csv, notes_geojson
from uwsim.recording.replay import replay as replay_recording
from uwsim.simulator.failures.events import comment_of, notes_of

LEVEL = (0.0, 0.0, 0.0, 1.0)


def chunks(png):
    return Image.open(io.BytesIO(png)).text


def test_a_camera_that_looks_down_by_an_angle_meets_the_bed_at_altitude_over_its_tangent():
    down, ahead = about_y(math.radians(30.0)), about_y(math.radians(90.0))
    port = product(about_z(math.radians(90.0)), LEVEL)
    far_m = 2.0 / math.tan(math.radians(30.0))
    for hull, camera, mount_m, expected in (
        (LEVEL, down, (0, 0, 0), (far_m, 0.0, -2.0)),
        (port, down, (0, 0, 0), (0.0, far_m, -2.0)),
        (down, LEVEL, (0, 0, 0), (far_m, 0.0, -2.0)),  # the hull's own pitch
        (LEVEL, ahead, (0.5, 0.0, 0.25), (0.5, 0.0, -2.0)),
    ):
        np.testing.assert_allclose(looked_at(hull, camera, mount_m, 2.0), expected, atol=1e-12)
    for pitch_deg, altitude_m in ((9.0, 1.0), (-30.0, 1.0), (30.0, math.inf), (11.0, 8.0)):
        assert looked_at(LEVEL, about_y(math.radians(pitch_deg)), (0, 0, 0), altitude_m) is None, "flat, far or unknown"


def test_notes_have_place_picture_and_files_and_a_recording_repeats_them(tmp_path):
    with serving(tmp_path) as (station, server), page(server) as ada, page(server, "Bob") as bob:
        ada.call("take_control")
        ada.call("start", scenario="pool", seed=3)
        live = station.present().live
        live.rov.undock()
        ada.call("control", action="record", name="dive")
        assert ada.call("notes", action="comment", vehicle="rov", text=" weld  12, süd ")["comment"] == "weld 12, süd"
        said = ada.call(
            "notes", action="add", vehicle="rov", category="defect", text="=crack", place="view", view="down"
        )
        assert "where its camera looks" in said["message"]
        said = ada.call("notes", action="add", vehicle="rov", category="debris", text="tin", place="vehicle")
        assert [note["category"] for note in said["notes"]] == ["defect", "debris"]
        looked, own = (np.array(note["position_m"]) for note in said["notes"])
        truth = live.read(
            lambda sim: (sim.rov.pose.position_world_m, sim.rov.telemetry().distance_to_seabed_m)
        ).result()
        np.testing.assert_allclose(own, truth[0], atol=0.3)
        assert own[2] - looked[2] == pytest.approx(truth[1], abs=0.3)  # on the bed, below

        png = chunks((tmp_path / said["notes"][0]["picture"]).read_bytes())
        values = json.loads(png["uwsim"])
        assert png["Title"] == "pool: down" and png["Comment"] == values["note"] == "=crack"
        assert values["comment"] == "weld 12, süd" and "depth_m=" in png["Description"]
        np.testing.assert_allclose(values["position_m"], own, atol=0.3)
        assert "true_position" not in values["panel"]
        picture = get(server, f"/notes/{said['notes'][0]['picture']}")
        assert picture[0] == 200 and picture[1][1:4] == b"PNG"

        assert "has the controls" in bob.call("notes", action="add", vehicle="rov", category="leak")["message"]
        assert bob.call("notes", action="list") == {**said, "message": ""}
        ada.call("control", action="stop_recording")
        rows = list(csv.DictReader(io.StringIO((tmp_path / "dive-notes.csv").read_text())))
        assert [row["category"] for row in rows] == ["comment", "defect", "debris"]
        assert rows[1]["text"] == "'=crack" and float(rows[2]["east_m"]) == pytest.approx(own[0], abs=1e-3)
        assert rows[0]["longitude_deg"] == "" and float(rows[2]["depth_m"]) == pytest.approx(-own[2], abs=1e-3)
        assert get(server, "/notes/notes.csv")[1] == (tmp_path / "dive-notes.csv").read_bytes()
        places = json.loads((tmp_path / "dive-notes.geojson").read_text())
        assert [each["geometry"] for each in places["features"]] == [None] * 3
        ada.call("notes", action="add", vehicle="rov", category="leak")  # without a recording: in files of their own
        assert (tmp_path / "pool-notes.csv").is_file() and len(rows) == 3
    repeated = replay_recording(tmp_path / "dive.mcap")
    assert repeated.difference is None
    commands = [one for one in uwsim.recording.open(tmp_path / "dive.mcap").commands() if one.name == "note"]
    assert [one.arguments["text"] for one in commands] == ["weld 12, süd", "=crack", "tin"]


def test_a_snapshot_carries_the_instruments_and_no_truth(tmp_path):
    with serving(tmp_path) as (station, server), page(server) as ada:
        ada.call("take_control")
        ada.call("start", scenario="pool", seed=3)
        live = station.present().live
        live.rov.undock()
        live.command("inject_fault", kind="sensor", sensor="depth", mode="stuck").result()
        live.command("place", vehicle="rov", position_world_m=[0.0, 0.0, -3.0]).result()
        live.pause()
        ada.call("notes", action="comment", vehicle="rov", text="weld")
        values = json.loads(chunks(get(server, "/snapshot/front.png")[1])["uwsim"])
        assert values["comment"] == "weld" and values["time_s"] == pytest.approx(1e-9 * live.time_ns, abs=1e-3)
        assert abs(values["depth_m"] - 3.0) > 0.3  # as the stuck gauge shows it
        live.simulator.vehicles["rov"].estimate  # noqa: B018
        assert values["panel"]["depth"] == pytest.approx(values["depth_m"], abs=0.01)


def test_wrong_notes_are_refused_and_leave_nothing(tmp_path):
    note = {"action": "add", "vehicle": "rov", "category": "leak"}
    with serving(tmp_path) as (station, server), page(server) as ada:
        station.start({"scenario": "pool"})
        ada.call("take_control")
        for args, expected in (
            ({"action": "draw"}, "must be one of list, add, comment"),
            (note | {"vehicle": "cow"}, "must be one of rov"),
            (note | {"category": "cow"}, "must be one of observation"),
            (note | {"category": "comment"}, "set a comment"),
            (note | {"text": "x" * 201}, "at most 200"),
            (note | {"text": "\u202ex"}, "printable"),
            (note | {"place": "sky"}, "must be one of view, vehicle"),
            (note | {"view": "../x"}, "must be one of front"),
            ({"action": "comment", "vehicle": "rov", "text": 5}, "must be text"),
        ):
            said = ada.call("notes", **args)
            assert not said["success"] and expected in said["message"]
            assert not notes_of(station.present().live.simulator.events) and not list(tmp_path.iterdir())
        for name in ("x.png", "..%2fx.png", "notes.exe"):
            assert get(server, f"/notes/{name}")[0] == 404


def test_a_saved_state_returns_to_its_notes_and_they_are_bounded():
    sim = uwsim.Simulator("pool")
    sim.rov.command("note", text="one", category="comment")
    state = sim.save_state()
    sim.rov.command("note", text="two", category="comment")
    assert comment_of(sim.events) == "two"
    sim.restore_state(state)
    assert comment_of(sim.events) == "one"
    for _ in range(499):
        sim.rov.command("note", text="", category="comment")
    assert comment_of(sim.events) == ""
    with pytest.raises(ValueError, match="there are 500 notes"):
        sim.rov.command("note", text="", category="leak")
    sim.reset()
    assert not notes_of(sim.events)


def test_a_place_on_the_central_meridian_has_its_longitude(tmp_path):
    """UTM zone 33 at its central meridian, where the easting is 500 km: 15 degrees east, by definition."""
    rasterio = pytest.importorskip("rasterio")
    path, heights = tmp_path / "bed.tif", np.full((1, 40, 40), -8.0, np.float32)
    with rasterio.open(
        path, "w", driver="GTiff", width=40, height=40, count=1, dtype="float32", crs="EPSG:32633",
        transform=rasterio.Affine(1, 0, 499_980, 0, -1, 6_000_020),
    ) as file:  # fmt: skip
        file.write(heights)
    (tmp_path / "earth.yaml").write_text(
        "name: earth\nterrain: {source: raster, file: bed.tif, water_level_m: 0}\nstation: {position_m: [0, 0, -2]}\n"
        "vehicles: [{name: rov, model: rov, start: {position_m: [0, 0, -3]}}]\n"
    )
    sim = uwsim.Simulator(tmp_path / "earth.yaml")
    from uwsim.scenario.georeference import georeference

    earth = georeference(sim.scenario)
    east_m, north_m = 500_000.0 - earth.origin[0], 6_000_000.0 - earth.origin[1]
    sim.rov.command("note", text="x", category="leak", position_world_m=(east_m, north_m, -3.0))
    point = json.loads(notes_geojson(sim, notes_of(sim.events)))["features"][0]["geometry"]["coordinates"]
    assert point[0] == pytest.approx(15.0, abs=1e-7) and point[2] == -3.0
    assert 54.0 < point[1] < 54.3
    assert b",15.0," in notes_csv(sim, notes_of(sim.events))


def test_the_pipeline_s_defects_can_be_reported_from_where_they_are_seen():
    """A vehicle above a defect, looking down at it, places its note within the goal's reach of the defect."""
    exercise = load_exercise("pipeline")
    goals = {goal.name: goal for goal in exercise.goals}
    with LiveSimulator(uwsim.Simulator(exercise.made_scenario()), paused=True) as live:
        x, y, z = goals["defect_2"].position_m
        live.command("place", vehicle="rov", position_world_m=[x, y, z + 1.5]).result()
        body_from_camera = live.simulator.rov.cameras["down"].mounting_xyzw()
        altitude_m = live.simulator.rov.telemetry().distance_to_seabed_m
        offset_m = looked_at(LEVEL, body_from_camera, live.simulator.rov.cameras["down"].mount.position_m, altitude_m)
        away_m = np.linalg.norm(np.array([x, y, z + 1.5]) + offset_m - goals["note_2"].position_m)
        assert away_m < goals["note_2"].within_m
