"""The operator's station over its own server: start, fly, watch, record, resume."""

import gc
import io
import math
import time
from contextlib import contextmanager
from weakref import ref

import numpy as np
import pytest
from PIL import Image

from browser import until
from station_pages import page, serving
from uwsim import Simulator
from uwsim.live import LiveSimulator, replay
from uwsim.operator.station.sessions.running import Running
from uwsim.recording.replay import replay as replay_recording


@contextmanager
def piloted(folder=None, **choice):
    """A station with a running pool, which Ada flies."""
    with serving(folder) as (station, server), page(server) as ada:
        ada.call("start", scenario="pool", **choice)
        ada.call("take_control")
        yield station, ada


@pytest.fixture(scope="module")
def pool():
    """A station with a running pool, for tests that do not stop it."""
    with serving() as (station, server):
        station.start({"scenario": "pool"})
        yield station, server


def test_from_the_start_screen_to_a_flight_and_back():
    with serving() as (station, server), page(server) as ada:
        ada.subscribe("/station/state")
        assert ada.message("/station/state")["phase"] == "idle"
        assert ada.call("describe") == {"success": False, "message": "no simulator is running: start one"}
        catalog = ada.call("catalog")
        assert {"lake", "pool"} <= {entry["name"] for entry in catalog["scenarios"]}
        assert [entry["name"] for entry in catalog["sonars"]][:4] == [1, 2, 3, 4]
        assert catalog["tilts_deg"] == [0.0, 60.0] and catalog["defaults"]["tilt_deg"] is None
        assert next(entry for entry in catalog["scenarios"] if entry["name"] == "paper")["tilt_deg"] == 60.0
        wrong = ada.call("check", scenario="pool", tilt_deg=91)
        assert list(wrong["errors"]) == ["tilt_deg"] and "tilt_deg = 91 deg: must be in" in wrong["errors"]["tilt_deg"]
        choice = {"scenario": "pool", "sonar": 4, "tilt_deg": 60, "seed": 7, "vehicle": "bluerov2_heavy", "speed": 0}
        assert ada.call("start", **catalog["defaults"] | choice)["success"]
        assert station.present().live.simulator.rov.sonar.elevation_rad == pytest.approx(-math.radians(60))
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


def test_a_page_that_sees_the_start_screen_may_start_at_once(monkeypatch):
    with serving() as (station, server), page(server) as ada:
        station.start({"scenario": "pool"})
        ada.subscribe("/station/state")
        ada.message("/station/state", lambda state: state["phase"] == "running")
        stop = Running.stop

        def slowly(running):
            station.sessions._publish()
            assert ada.message("/station/state", lambda state: state["phase"] != "running")["phase"] == "starting"
            stop(running)

        monkeypatch.setattr(Running, "stop", slowly)
        station.sessions.quit()
        monkeypatch.undo()
        ada.message("/station/state", lambda state: state["phase"] == "idle")
        assert ada.call("start", scenario="pool")["success"]


def test_the_member_who_starts_a_simulator_flies_it_after_another_was_lost():
    with serving() as (station, server), page(server, "Bob") as bob:
        bob.subscribe("/station/state")
        with page(server, "Ada") as ada:
            assert ada.call("start", scenario="pool")["success"] and ada.call("control", action="quit")["success"]
        bob.message("/station/state", lambda state: state["lost_by"] == "Ada")
        assert bob.call("start", scenario="pool")["success"]
        state = bob.message("/station/state", lambda state: state["phase"] == "running")
        assert (station.lease.pilot, station.lease.lost_by) == (bob.id, "")
        assert state["lost_by"] == "" and bob.call("drive", vehicle="rov", surge=0.5)["success"]


def test_exercises_are_started_from_the_start_screen_and_one_after_another(tmp_path):
    with serving(tmp_path) as (station, server), page(server, "Ada") as ada:
        wrong = ada.call("start", exercise_name="hoover")["errors"]
        assert wrong["exercise_name"].startswith("'hoover': must be one of hover, slalom")
        assert ada.call("start", exercise_name="hover", seed=1)["errors"] == {"seed": "is the exercise's own"}
        assert ada.call("start", exercise_name="hover")["success"] and station.lease.pilot == ada.id
        described = ada.call("describe")
        assert described["has_exercise"] and not described["truth_allowed"] and "quit" in described["controls"]
        state = ada.call("exercise")
        assert (state["name"], state["next_name"], state["next_title"]) == ("hover", "slalom", "Gate slalom")
        course = station.present().judged.course
        assert ada.call("control", action="begin")["success"]
        station.present().live.read(lambda sim: course.judge()).result()
        assert ada.call("start", exercise_name=state["next_name"])["success"]
        assert ada.call("exercise")["name"] == "slalom"
        assert ada.call("control", action="quit")["success"]
        catalog = ada.call("catalog")
        assert "own" not in [each["group"] for each in catalog["scenarios"]]


def test_what_is_wrong_is_said_at_its_field():
    with serving() as (_, server), page(server) as ada:
        wrong = {"scenario": "/etc/passwd", "speed": -1, "link": "string"}
        assert set(ada.call("check", **wrong)["errors"]) == set(wrong)
        wrong = {"vehicle": "../rov.yaml", "sonar": 9, "seed": 1.5, "mission_time_s": -3, "colour": "red"}
        answer = ada.call("start", **wrong)
        assert not answer["success"] and set(answer["errors"]) == set(wrong)
        assert ada.call("check", scenario="pool") == {"success": True, "message": "", "errors": {}}


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
        for other in ([bob.id], {}, 5, "absent"):
            assert "is not a member" in ada.call("hand_over", to=other)["message"]
        for call, args in (
            ("plan", {"action": "fly", "points_m": [[1, 0, -2]]}),
            ("notes", {"action": "add", "text": "a", "category": "leak"}),
        ):
            assert "vehicle = ['rov']: must be one of rov" in ada.call(call, vehicle=["rov"], **args)["message"]
        both = ada.call("command", name="undock", vehicle="rov", args={"vehicle": "rov"})
        assert both["message"] == "args.vehicle: is given beside args"
        assert ada.call("hand_over", to=bob.id)["success"]
        station.present().live.read(lambda sim: None).result()
        assert not station.present().live.rov.effort.any()
        assert bob.call("drive", vehicle="rov", surge=0.25)["success"]
        assert not ada.call("drive", vehicle="rov", surge=1.0)["success"]


def test_one_hand_at_a_time_and_all_see_whose_it_is():
    """While a pilot has the controls, other clients of the same server command no vehicle; all may stop it."""
    ahead = {"position": {"x": 1.0, "y": 0.0, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 0.0}}
    with serving() as (station, server), page(server, "Ada") as ada, page(server, "a program") as other:
        station.start({"scenario": "pool"})
        live = station.present().live

        def ask(service, **args):
            other.send("call_service", service=service, args=args, id=service)
            return other.next(lambda o: o.get("id") == service)["values"]

        other.subscribe("/station/state")
        other.send("publish", topic="/key", msg=ahead)
        assert other.message("/station/state", lambda s: s["driver"])["driver"] == "a rosbridge client"
        assert live.read(lambda sim: sim.rov.effort[0]).result() == 1.0
        assert ada.call("take_control")["success"]
        other.message("/station/state", lambda s: s["pilot"] == ada.id and s["driver"] == "")
        live.read(lambda sim: None).result()
        assert not live.rov.effort.any()

        commands = [entry for entry in live.log if entry.name != "start_navigation"]
        for topic, msg in (("/key", ahead), ("/cmd_vel", {"linear": {"x": 1.0}}), ("/cmd_tilt", {"data": 0.1})):
            other.send("publish", topic=topic, msg=msg)
            assert "Ada has the controls" in other.next(lambda o: o["op"] == "status")["msg"]
        for service, args in (("/release", {}), ("/lights/front", {"data": True}), ("/all_stop", {"data": False})):
            answer = ask(service, **args)
            assert not answer["success"] and "Ada has the controls" in answer["message"], service
        assert [entry for entry in live.log if entry.name != "start_navigation"] == commands
        assert ask("/simulation/pause")["success"] and ask("/simulation/resume")["success"]
        assert ask("/all_stop", data=True)["success"] and live.rov.all_stopped

        ada.socket.close()
        assert other.message("/station/state", lambda s: not s["pilot"])["lost_by"] == "Ada"
        assert ask("/all_stop", data=False)["success"] and ask("/release")["success"] and live.rov.released


def test_a_lost_connection_ends_the_efforts_and_frees_the_controls(pool):
    station, server = pool
    live = station.present().live
    with page(server, "Bob") as bob:
        bob.subscribe("/station/state")
        with page(server, "Ada") as ada:
            ada.call("take_control")
            ada.call("drive", vehicle="rov", surge=0.5)
            assert 0.5 in [entry.arguments["surge"] for entry in live.log if entry.name == "set_effort"]
            ada.socket.socket.close()  # without a closing handshake
        bob.message("/station/state", lambda state: not state["pilot"] and len(state["member_ids"]) == 1)
        until(lambda: not live.rov.effort.any(), "no effort")
        assert bob.call("take_control")["success"]


def test_a_link_that_is_down_takes_no_commands_of_the_page_until_it_is_back():
    with piloted(speed=5) as (station, ada):
        asked = {"name": "set_lamp", "vehicle": "rov", "args": {"lamp": "front", "on": True}}
        fault = {"name": "inject_fault", "args": {"kind": "link", "name": "cut", "for_s": 1e5}}
        assert ada.call("command", **fault)["success"]  # addressed to the simulator, so it bypasses the link
        answer = ada.call("command", **asked)
        assert not answer["success"] and "the link to 'rov' is down" in answer["message"]
        for topic in ("/link", "/station/small/front", "/station/small/station"):
            ada.subscribe(topic)
        assert ada.message("/link")["fault_loss"] == 1.0
        for _ in range(2):
            ada.message("/station/small/station")
        assert not [o for o in ada.heard if o.get("topic") == "/station/small/front"], "nobody sees the vehicle's"
        assert ada.call("command", name="end_fault", args={"name": "cut"})["success"]
        assert ada.call("command", **asked)["success"]
        assert station.present().live.simulator.rov.lamps["front"].on
        assert ada.message("/station/small/front")


def test_what_a_pilot_flew_is_recorded_and_replays_to_the_same_bytes(tmp_path):
    with piloted(tmp_path, speed=5, seed=3) as (station, ada):
        ada.subscribe("/station/state")
        assert "nothing is being recorded" in ada.call("control", action="stop_recording")["message"]
        assert ada.call("control", action="record", name="dive")["success"]
        assert ada.message("/station/state", lambda state: state["recording"])["recording"] == "dive.mcap"
        ada.call("command", name="release", vehicle="rov")
        for k in range(6):
            assert ada.call("drive", vehicle="rov", surge=0.1 * k, yaw=-0.5)["success"]
            time.sleep(0.05)
        ada.call("command", name="set_lamp", vehicle="rov", args={"lamp": "front", "on": True})
        live = station.present().live
        until(lambda: not live.rov.effort.any(), "zero, without commands")
        until(lambda: live.time_ns > 3e9, "some messages")
        assert ada.call("control", action="stop_recording")["success"]
        ada.call("control", action="pause")
        surges = [entry.arguments["surge"] for entry in live.log if entry.name == "set_effort"]
        assert [surge for surge in surges if surge] == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5])  # slowly: zeros between
        again = replay(Simulator("pool", seed=3), live.log, live.simulator.tick)
        assert again.save_state() == live.simulator.save_state()
    found = replay_recording(tmp_path / "dive.mcap")
    assert found.difference is None and found.commands >= 8  # the last command is zero, sent after the silence
    assert found.messages["telemetry"] > 5


def test_views_are_made_while_somebody_looks_and_stop_at_the_credit(pool):
    station, server = pool
    with page(server) as ada:

        def size_of(topic):
            picture = Image.open(io.BytesIO(bytes(ada.message(topic)["data"])))
            return picture.format, picture.size

        view = next(view for view in ada.call("describe")["views"] if view["name"] == "front")
        assert ada.call("set_view", name="front", width=160, rate_hz=10)["success"]
        assert "quality" in ada.call("set_view", name="front", quality=0)["message"]
        ada.subscribe(view["topic"], credit=2)
        for _ in range(2):
            assert size_of(view["topic"]) == ("JPEG", (160, 90))
        ada.subscribe(view["small_topic"])
        assert size_of(view["small_topic"]) == ("JPEG", (240, 135))
        time.sleep(0.5)
        ada.heard.clear()
        ada.call("describe")
        assert not [o for o in ada.heard if o.get("topic") == view["topic"]]  # both credits are used up
        ada.send("ack", topic=view["topic"], count=2)
        ada.message(view["topic"])
        for topic in (view["topic"], view["small_topic"]):
            ada.send("unsubscribe", topic=topic)
        ada.call("describe")
        large = station.present().views.views["front"].large

        def is_idle():
            rendered = large.due_s
            time.sleep(0.3)
            return large.due_s == rendered

        until(is_idle, "no further pictures")


def test_pilots_may_be_kept_from_the_truth():
    with serving(truth=False) as (_, server), page(server) as ada:
        ada.call("start", scenario="pool")
        assert ada.call("describe")["truth_allowed"] is False
        ada.subscribe("/telemetry")
        told = ada.message("/telemetry")
        assert np.isnan(told["true_position"]).all() and np.isfinite(told["position"]).all()


def test_a_saved_session_goes_on(tmp_path):
    with piloted(tmp_path, seed=5, speed=5) as (station, ada):
        ada.call("command", name="release", vehicle="rov")
        ada.call("drive", vehicle="rov", surge=0.3, heave=-0.2)
        live = station.present().live
        until(lambda: not live.rov.effort.any(), "zero, without commands")
        ada.call("control", action="pause")  # nothing changes it from now on
        ada.call("control", action="save", name="dive")
        saved, voxels = (
            (live.simulator.tick, live.simulator.save_state()),
            len(station.present().maps["rov"].points()[0]),
        )
        ada.call("control", action="quit")
        assert ada.call("catalog")["saves"] == ["dive"]
        assert ada.call("start", saved="../dive")["errors"]
        assert ada.call("start", saved="dive", seed=1)["errors"]["seed"]
        found = []
        begin = LiveSimulator.__init__

        def note(live, simulator, **options):
            found.append((simulator.tick, simulator.save_state()))
            begin(live, simulator, **options)

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(LiveSimulator, "__init__", note)
            assert ada.call("start", saved="dive", speed=0.1)["success"]  # later views may free some voxels
        assert found == [saved]
        assert station.present().live.simulator.seed == 5
        ada.subscribe("/map_changes")
        assert len(ada.message("/map_changes")["cells"]) >= 0.9 * voxels


def test_a_simulator_that_has_ended_leaves_nothing_behind():
    with serving() as (station, server), page(server) as ada:
        for topic in ("/map_changes", "/station/view/front", "/scan", "/octomap_binary"):
            ada.subscribe(topic)
        gone = []
        for _ in range(2):
            station.start({"scenario": "pool"})
            gone.append(ref(station.present().live.simulator))
            ada.message("/scan")
        station.sessions.quit()
        until(lambda: gc.collect() is not None and not any(simulator() for simulator in gone), "the end of both")
