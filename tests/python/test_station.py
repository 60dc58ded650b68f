"""The operator's station over its own server: start, fly, watch, take the map home."""

import gc
import io
import json
import time
from weakref import ref

import numpy as np
import pytest
import trimesh
from PIL import Image

from station_pages import PATIENCE_S, get, page, serving
from uwsim import Simulator
from uwsim.bridges import RosbridgeServer
from uwsim.bridges.rosbridge.admission import has_token
from uwsim.live import LiveSimulator, replay
from uwsim.mapping import OccupancyMap
from uwsim.recording.replay import replay as replay_recording
from uwsim.station import Site, Station
from uwsim.station.preview import AREA, OBSTACLE, STATION


@pytest.fixture(scope="module")
def pool():
    """A station whose pool runs, for tests that leave it running."""
    with serving() as (station, server):
        station.start({"scenario": "pool"})
        yield station, server


def test_from_the_start_screen_to_a_flight_and_back():
    with serving() as (_, server), page(server) as ada:
        ada.subscribe("/station/state")
        assert ada.message("/station/state")["phase"] == "idle"
        assert ada.call("describe") == {"success": False, "message": "no simulator runs: start one"}
        catalog = ada.call("catalog")
        assert {"lake", "pool"} <= {entry["name"] for entry in catalog["scenarios"]}
        assert [entry["name"] for entry in catalog["sonars"]][:4] == [1, 2, 3, 4]
        choice = {"scenario": "pool", "sonar": 4, "seed": 7, "vehicle": "bluerov2_heavy", "speed": 0}
        assert ada.call("start", **catalog["defaults"] | choice)["success"]
        state = ada.message("/station/state", lambda state: state["phase"] == "running")
        told = ada.call("describe")
        assert (told["seed"], told["session"], told["scenario"]) == (7, state["session"], "pool")
        (vehicle,) = told["vehicles"]
        assert vehicle["model"] == "bluerov2_heavy" and vehicle["sonar"]["beams"] == 1025
        ada.subscribe(vehicle["telemetry"], throttle_rate=50)
        assert len(ada.message("/telemetry")["thrusters"]) == len(vehicle["thrusters"]) == 8
        ada.call("take_control")
        assert ada.call("control", action="quit")["success"]
        ada.message("/station/state", lambda state: state["phase"] == "idle")
        assert ada.call("start", scenario="pool")["success"]
        ada.message("/telemetry", lambda message: message["header"]["stamp"]["secs"] >= 0)  # still subscribed
        assert ada.call("describe")["session"] > state["session"]


def test_what_is_wrong_is_said_at_its_field():
    with serving() as (_, server), page(server) as ada:
        wrong = {"scenario": "/etc/passwd", "speed": -1, "link": "string"}
        assert set(ada.call("check", **wrong)["errors"]) == set(wrong)
        wrong = {"vehicle": "../rov.yaml", "sonar": 9, "seed": 1.5, "mission_time_s": -3, "colour": "red"}
        answer = ada.call("start", **wrong)
        assert not answer["success"] and set(answer["errors"]) == set(wrong)
        assert ada.call("check", scenario="pool") == {"success": True, "message": "", "errors": {}}


def test_the_start_screen_has_a_picture_of_each_scenario_from_above():
    with serving() as (_, server):
        status, body, headers = get(server, "/preview/pool.png")
        assert (status, headers["Content-Type"]) == (200, "image/png")
        picture = np.asarray(Image.open(io.BytesIO(body)).convert("RGB"))
        height, width, _ = picture.shape
        assert width == height  # 20 m

        def colour_at(x_m, y_m):
            return tuple(picture[round(height * (10.0 - y_m) / 20.0), round(width * (10.0 + x_m) / 20.0)])

        assert (colour_at(3.0, 0.0), colour_at(-6.0, 0.0), colour_at(4.0, 2.0)) == (OBSTACLE, STATION, AREA)
        assert colour_at(0.0, 2.0) == colour_at(0.0, -2.0)  # the flat bed
        assert get(server, "/preview/../pool.png")[0] == get(server, "/preview/nowhere.png")[0] == 404
    with serving(is_fixed=True) as (_, server):
        assert get(server, "/preview/pool.png")[0] == 404


def test_one_flies_and_the_other_watches_until_the_controls_are_handed_over(pool):
    station, server = pool
    with page(server, "Ada") as ada, page(server, "Bob") as bob:
        bob.subscribe("/station/state")
        assert ada.call("take_control")["success"]
        assert "Ada has the controls" in bob.call("take_control")["message"]
        state = bob.message("/station/state", lambda state: state["asking"])
        assert (state["pilot"], state["asking"]) == (ada.id, [bob.id])
        for call, args in (
            ("drive", {"vehicle": "rov", "surge": 1.0}),
            ("command", {"name": "release", "vehicle": "rov"}),
            ("control", {"action": "pause"}),
            ("start", {"scenario": "pool"}),
        ):
            assert "Ada has the controls" in bob.call(call, **args)["message"], call
        assert ada.call("drive", vehicle="rov", surge=0.5)["success"]
        assert ada.call("hand_over", to=bob.id)["success"]
        station.running.live.read(lambda sim: None).result()
        assert not station.running.live.rov.effort.any()
        assert bob.call("drive", vehicle="rov", surge=0.25)["success"]
        assert not ada.call("drive", vehicle="rov", surge=1.0)["success"]


def test_a_lost_connection_ends_the_efforts_and_frees_the_controls(pool):
    station, server = pool
    live = station.running.live
    with page(server, "Bob") as bob:
        bob.subscribe("/station/state")
        with page(server, "Ada") as ada:
            ada.call("take_control")
            ada.call("drive", vehicle="rov", surge=0.5)
            assert live.rov.effort[0] == 0.5
            ada.socket.socket.close()  # no goodbye
        bob.message("/station/state", lambda state: not state["pilot"] and len(state["member_ids"]) == 1)
        deadline = time.monotonic() + PATIENCE_S
        while live.rov.effort.any():
            assert time.monotonic() < deadline
            time.sleep(0.01)
        assert bob.call("take_control")["success"]


def test_what_a_pilot_flew_replays_to_the_same_bytes():
    with serving() as (station, server), page(server) as ada:
        ada.call("start", scenario="pool", speed=5, seed=3)
        ada.call("take_control")
        ada.call("command", name="release", vehicle="rov")
        for k in range(6):
            answer = ada.call("drive", vehicle="rov", surge=0.1 * k, yaw=-0.5, stamp_ms=1e3 * time.monotonic())
            assert answer["success"]
            time.sleep(0.05)
        ada.call("command", name="set_lamp", vehicle="rov", args={"lamp": "front", "on": True})
        time.sleep(0.7)  # silence
        ada.call("control", action="pause")
        live = station.running.live
        log = list(live.log)
        assert not live.rov.effort.any() and log[-1].name == "set_effort"
        surges = [entry.arguments["surge"] for entry in log if entry.name == "set_effort"]
        assert surges == pytest.approx([0, 0.1, 0.2, 0.3, 0.4, 0.5, 0])
        again = replay(Simulator("pool", seed=3), live.log, live.simulator.tick)
        assert again.save_state() == live.simulator.save_state()


def test_views_are_made_while_somebody_looks_and_stop_at_the_credit(pool):
    station, server = pool
    with page(server) as ada:
        view = next(view for view in ada.call("describe")["views"] if view["name"] == "front")
        assert ada.call("set_view", name="front", width=160, rate_hz=10)["success"]
        assert "quality" in ada.call("set_view", name="front", quality=0)["message"]
        ada.subscribe(view["topic"], credit=2)
        for _ in range(2):
            picture = Image.open(io.BytesIO(bytes(ada.message(view["topic"])["data"])))
            assert (picture.format, picture.size) == ("JPEG", (160, 90))
        ada.subscribe(view["small_topic"])
        small = Image.open(io.BytesIO(bytes(ada.message(view["small_topic"])["data"])))
        assert small.size == (240, 135)
        time.sleep(0.5)
        ada.heard.clear()
        ada.call("describe")
        assert not [o for o in ada.heard if o.get("topic") == view["topic"]]  # two are on their way
        ada.send("ack", topic=view["topic"], count=2)
        ada.message(view["topic"])
        for topic in (view["topic"], view["small_topic"]):
            ada.send("unsubscribe", topic=topic)
        ada.call("describe")
        large = station.running.views.views["front"].large
        time.sleep(0.2)
        rendered = large.due_s
        time.sleep(0.3)
        assert large.due_s == rendered


def test_the_map_goes_home_in_every_format(tmp_path):
    with serving(tmp_path) as (_, server), page(server) as ada:
        ada.call("start", scenario="pool", speed=2)
        ada.subscribe("/map_changes", throttle_rate=100)
        first = ada.message("/map_changes")
        assert first["snapshot"] and len(first["cells"]) > 0
        ada.call("take_control")
        ada.call("control", action="pause")
        status, body, headers = get(server, "/map/rov.bt")
        assert (status, headers["Content-Disposition"]) == (200, 'attachment; filename="rov.bt"')
        (tmp_path / "map.bt").write_bytes(body)
        voxels = OccupancyMap.read(tmp_path / "map.bt").occupied_voxels()
        assert len(voxels) > 20
        for suffix, start in (("ply", b"ply"), ("pcd", b"# .PCD"), ("tif", b"II*\0")):
            status, body, _ = get(server, f"/map/rov.{suffix}")
            assert status == 200 and body.startswith(start)
        assert get(server, "/map/boat.bt")[0] == get(server, "/map/rov.exe")[0] == 404
        assert "saved" in ada.call("control", action="save", name="dive-1")["message"]
        saved = {path.name for path in (tmp_path / "dive-1").iterdir()}
        assert saved >= {"rov.bt", "rov.ot", "state", "commands.json", "scenario.json"}
        assert "there already" in ada.call("control", action="save", name="dive-1")["message"]
        assert "must have" in ada.call("control", action="save", name="../dive")["message"]
        status, body, _ = get(server, "/snapshot/front.png")
        assert status == 200 and Image.open(io.BytesIO(body)).size == (640, 360)
        assert json.loads(get(server, "/snapshot/front.json")[1])["released"] is False
        assert get(server, "/snapshot/none.png")[0] == 404


def test_the_scene_is_the_world(pool):
    station, server = pool
    world = station.running.live.simulator.world
    scene = json.loads(get(server, "/scene/scene.json")[1])
    grid = scene["terrain"]
    heights = np.frombuffer(get(server, grid["url"])[1], "<f4").reshape(grid["rows"], grid["columns"])
    row, column = grid["rows"] // 3, grid["columns"] // 4
    x, y = grid["west_m"] + column * grid["spacing_m"][0], grid["south_m"] + row * grid["spacing_m"][1]
    assert heights[row, column] == pytest.approx(float(np.ravel(world.height_at([[x, y]]))[0]), abs=1e-4)
    meshes = [trimesh.load(io.BytesIO(get(server, part["url"])[1]), file_type="glb") for part in scene["meshes"]]
    assert len(meshes) == len(scene["meshes"]) > 0 and all(len(mesh.geometry) for mesh in meshes)
    hull = trimesh.load(io.BytesIO(get(server, scene["vehicles"][0]["url"])[1]), file_type="glb")
    assert 0.5 < np.ptp(hull.bounds, axis=0).max() < 3.0
    assert get(server, "/scene/mesh/999.glb")[0] == 404


def test_only_this_machine_s_pages_are_served_and_nothing_foreign_is_loaded(pool):
    _, server = pool
    status, body, headers = get(server, "/")
    assert status == 200 and b"<script" in body and b"http" not in body.replace(b"http-equiv", b"")
    policy = headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy and "script-src 'self';" in policy and "unsafe" not in policy
    assert f"ws://127.0.0.1:{server.port}" in policy and "ws://10.0.0.9:9090" not in policy
    assert "ws://10.0.0.9:9090" in get(server, "/?rosbridge=ws://10.0.0.9:9090")[2]["Content-Security-Policy"]
    for evil in ("ws://x;script-src%20*", "https://evil.example", "ws://a%20b"):
        assert get(server, f"/?rosbridge={evil}")[2]["Content-Security-Policy"] == policy
    assert get(server, "/", If_None_Match=headers["ETag"])[0] == 304
    assert (
        get(server, "/", Host="evil.example")[0] == get(server, "/map/rov.bt", Origin="http://evil.example")[0] == 403
    )
    mine = "http://localhost:5173"  # a page of one's own
    assert get(server, "/scene/scene.json", Origin=mine)[2]["Access-Control-Allow-Origin"] == mine
    assert get(server, "/scene/scene.json")[2]["Access-Control-Allow-Origin"] is None
    assert get(server, "/snapshot/front.png", Sec_Fetch_Site="cross-site")[0] == 403  # an <img> of another page
    for path in ("/../hub.py", "/%2e%2e/hub.py", "/..%2f..%2fsimulator.py", "//etc/passwd", "/no", "/%00", "/style"):
        assert get(server, path)[0] == 404, path


def test_a_token_guards_everything_but_the_page_s_own_files():
    station, token = Station(), "secret-token"
    site = Site(station, lambda request: has_token(request, token))
    with RosbridgeServer(None, guests=[station], site=site, token=token) as server, station.serving(server.show):
        station.start({"scenario": "pool"})
        assert get(server, "/")[0] == 200
        assert get(server, "/scene/scene.json")[0] == 401
        assert get(server, "/scene/scene.json?token=secret-token")[0] == 200


def test_pilots_may_be_kept_from_the_truth():
    with serving(truth=False) as (_, server), page(server) as ada:
        ada.call("start", scenario="pool")
        assert ada.call("describe")["truth_allowed"] is False
        ada.subscribe("/telemetry")
        told = ada.message("/telemetry")
        assert np.isnan(told["true_position"]).all() and np.isfinite(told["position"]).all()


def test_a_flight_is_recorded_and_replays(tmp_path):
    with serving(tmp_path) as (_, server), page(server) as ada:
        ada.call("start", scenario="pool", speed=5)
        ada.subscribe("/station/state")
        ada.call("take_control")
        assert "nothing is being recorded" in ada.call("control", action="stop_recording")["message"]
        assert ada.call("control", action="record", name="dive")["success"]
        assert ada.message("/station/state", lambda state: state["recording"])["recording"] == "dive.mcap"
        ada.call("command", name="release", vehicle="rov")
        ada.call("drive", vehicle="rov", surge=0.5, heave=-0.2)
        time.sleep(0.8)
        assert ada.call("control", action="stop_recording")["success"]
    found = replay_recording(tmp_path / "dive.mcap")
    assert found.difference is None and found.commands >= 3  # the last one is zero, after silence
    assert found.messages["telemetry"] > 5


def test_a_saved_session_goes_on(tmp_path):
    with serving(tmp_path) as (station, server), page(server) as ada:
        ada.call("start", scenario="pool", seed=5, speed=5)
        ada.call("take_control")
        ada.call("command", name="release", vehicle="rov")
        ada.call("drive", vehicle="rov", surge=0.3, heave=-0.2)
        time.sleep(0.3)
        ada.call("control", action="pause")
        ada.call("control", action="save", name="dive")
        sim = station.running.live.simulator
        tick, state, voxels = sim.tick, sim.save_state(), len(station.running.maps["rov"].points()[0])
        ada.call("control", action="quit")
        assert ada.call("catalog")["saves"] == ["dive"]
        assert (
            ada.call("start", saved="../dive")["errors"] and ada.call("start", saved="dive", seed=1)["errors"]["seed"]
        )
        found = []
        begin = LiveSimulator.__init__

        def note(live, simulator, **options):
            found.append((simulator.tick, simulator.save_state()))
            begin(live, simulator, **options)

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(LiveSimulator, "__init__", note)
            assert ada.call("start", saved="dive", speed=0)["success"]
        assert found == [(tick, state)]
        assert station.running.live.simulator.seed == 5
        ada.subscribe("/map_changes")
        assert len(ada.message("/map_changes")["cells"]) >= 0.9 * voxels


def test_a_simulator_that_has_ended_leaves_nothing_behind():
    with serving() as (station, server), page(server) as ada:
        for topic in ("/map_changes", "/station/view/front", "/scan", "/octomap_binary"):
            ada.subscribe(topic)
        gone = []
        for _ in range(2):
            station.start({"scenario": "pool"})
            gone.append(ref(station.running.live.simulator))
            ada.message("/scan")
        station.quit()
        deadline = time.monotonic() + PATIENCE_S
        while any(simulator() is not None for simulator in gone):
            assert time.monotonic() < deadline
            gc.collect()
            time.sleep(0.05)
