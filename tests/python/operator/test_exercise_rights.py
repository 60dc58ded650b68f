"""While an exercise is flown, no client changes the world, and the sheet lists what helped."""

import json
import time
from contextlib import contextmanager
from unittest.mock import Mock

import numpy as np
import pytest

from browser import until
from station_pages import page, serving
from uwsim.bridges.actions import actions_of
from uwsim.bridges.bridge import Bridge
from uwsim.bridges.ros2.parameters import parameter_channel
from uwsim.bridges.rosbridge.parameters import Parameters as RosbridgeParameters
from uwsim.channels.calls.parameter_table import ParameterTable
from uwsim.channels.calls.rcl_parameters import rcl_parameter_services
from uwsim.channels.ros import build
from uwsim.exercises import load_exercise
from uwsim.exercises.exercise import Aid
from uwsim.live import COMMANDS
from uwsim.operator.station.flights.flights import Bounds
from uwsim.recording.replay import replay

pytestmark = pytest.mark.usefixtures("blank_figures")  # of the sheets
CLOSED = "no client may change the world"
VALUES = {
    "place": {"vehicle": "rov", "position_world_m": [0.0, 0.0, -2.0]},
    "apply_wrench": {"vehicle": "rov", "force_n": [1.0, 0.0, 0.0]}, "inject_fault": {"kind": "sonar"},
    "push_object": {"object": "crate", "force_n": [1.0, 0.0, 0.0]},
    "end_fault": {"name": "sonar"}, "set_optics": {"sun_elevation_deg": 10.0},
    "cut_tether": {"vehicle": "rov", "at_m": 1.0}, "cut_object_tether": {"object": "crate", "at_m": 1.0},
    "reload": {"vehicle": "rov", "dropper": "bay"},
    "set_object_winch": {"object": "crate", "rate_m_s": 0.1},
    "set_parameter": {"name": "mission_time_s", "value": 9.0},
    "set_parameters": {"changes": {"mission_time_s": 9.0}}, "reset_parameters": {},
}  # fmt: skip
REQUESTS = {"simulation/step": {"steps": 3}, "simulation/set_speed": {"speed": 9.0},
            "simulation/set_parameters": {"values_json": '{"mission_time_s": 9}'}}  # fmt: skip
READS = ("simulation/pace", "simulation/list_parameters", "simulation/get_parameters", "simulation/describe_parameters")


def hover(*aids: Aid, time_s: float = 60.0):
    return load_exercise("hover").model_copy(update={"aids": list(aids), "time_s": time_s})


@pytest.fixture
def exercise(tmp_path):
    with serving(tmp_path, is_fixed=True, truth=False) as (station, server):
        station.run_exercise(hover())
        yield station, server


@contextmanager
def attempt(folder, exercise=None, **options):
    """A station at which Ada has begun an attempt."""
    with serving(folder, is_fixed=True, truth=False, **options) as (station, server), page(server) as ada:
        station.run_exercise(exercise or hover())
        begin(ada)
        yield station, server, ada


def begin(ada) -> None:
    ada.call("take_control")
    answer = ada.call("control", action="begin")
    assert answer["success"], answer


def score_of(station, number=1):
    path = station.sessions.folder / f"sheet-{number}/score.json"
    until(path.is_file, "the sheet")
    return json.loads(path.read_text())


def test_every_door_to_the_world_is_closed(exercise):
    """All services, all parameter protocols and all commands: each is refused with the reason, and changes nothing."""
    station, _ = exercise
    running = station.present()
    live, table = running.live, running.table
    before = live.read(lambda sim: sim.save_state()).result(), live.simulator.parameters.scenario, live.tick
    with Bridge("test", live, table.channels, [*table.services, *rcl_parameter_services("uwsim")]) as bridge:
        for name, service in bridge.services.items():
            if name.startswith("simulation/") and name not in READS:
                answer = bridge.respond(service, REQUESTS.get(name, {}))
                assert not answer["success"] and CLOSED in answer["message"], name
        one = build.message("rcl_interfaces/msg/Parameter", name="mission_time_s", value=double(9.0))
        (set_service,) = [each for each in bridge.services.values() if each.name.endswith("/set_parameters")
                          and each.type == "rcl_interfaces/srv/SetParameters"]  # fmt: skip
        (result,) = bridge.respond(set_service, {"parameters": [one]})["results"]
        assert not result["successful"] and CLOSED in result["reason"]
        with pytest.raises(ValueError, match=CLOSED):
            parameter_channel(lambda level, text: None).apply(live, one)
    with pytest.raises(ValueError, match=CLOSED):
        RosbridgeParameters({}, lambda: live).set_json("mission_time_s", "9")
    with pytest.raises(ValueError, match=CLOSED):
        ParameterTable(live).set({"mission_time_s": 9.0})
    assert {name for name, command in COMMANDS.items() if command.changes_world} == set(VALUES)
    for name, arguments in VALUES.items():
        with pytest.raises(ValueError, match=CLOSED):
            live.command(name, **arguments)
    for act in (live.pause, live.resume, live.step, live.reset, lambda: live.call(print), lambda: set_speed(live)):
        with pytest.raises(ValueError, match=CLOSED):
            act()
    assert before == (live.read(lambda sim: sim.save_state()).result(), live.simulator.parameters.scenario, live.tick)
    assert live.paused and live.speed == 1.0 and not live.log


def set_speed(live) -> None:
    live.speed = 20.0


def double(value):
    return build.message("rcl_interfaces/msg/ParameterValue", type=3, double_value=value)


def test_mavlink_neither_sets_parameters_nor_flies(exercise):
    pytest.importorskip("pymavlink", reason="needs the extra mavlink")
    from mavlink_station import Station as GroundStation
    from uwsim.bridges.mavlink import MavlinkVehicle
    from uwsim.bridges.mavlink.endpoint import FORM

    running = exercise[0].present()
    flight = next(each for each in actions_of(running.live.simulator, running.table) if each.name == "fly_path")
    endpoint = FORM.parse("tcp:127.0.0.1:0")
    with MavlinkVehicle(
        running.live, endpoint, running.table.channels, running.table.services, action=flight
    ) as vehicle:
        ground = GroundStation(f"tcp:{vehicle.endpoint.host}:{vehicle.endpoint.port}")
        mass = running.live.simulator.parameters["rov.mass_kg"]
        ground.mav.param_set_send(1, 1, b"MASS_KG", 14.0, 9)
        assert ground.receive("PARAM_VALUE", lambda value: value.param_id == "MASS_KG").param_value == np.float32(mass)
        assert ground.receive("STATUSTEXT", lambda text: "set_parameter: refused: an exercise" in text.text)
        assert ground.mode(2) == 4  # MAV_RESULT_FAILED, of a mode with holds
        ground.close()
    assert running.live.simulator.parameters["rov.mass_kg"] == mass


def test_without_a_pilot_programs_do_not_fly_and_anyone_may_stop(exercise):
    running = exercise[0].present()
    with Bridge("test", running.live, running.table.channels, running.table.services) as bridge:
        for channel in [each for each in bridge.inputs.values() if each.over_link]:
            with pytest.raises(ValueError, match="program: refused: the exercise does not allow this aid"):
                bridge.apply(channel, channel.authority.idle)
        assert "does not allow" in bridge.respond(bridge.services["hold"], {"heading": True})["message"]
        assert bridge.respond(bridge.services["all_stop"], {"data": True})["success"]


def test_the_page_of_a_pilot_has_no_more_rights(exercise):
    with page(exercise[1]) as ada:
        begin(ada)
        for action in ("pause", "resume", "step", "speed"):
            assert CLOSED in ada.call("control", action=action, speed=9, steps=1)["message"]
        for action in ("save", "quit"):
            assert "must be one of begin, restart" in ada.call("control", action=action)["message"]
        for name, arguments in VALUES.items():
            assert CLOSED in ada.call("command", name=name, args=arguments)["message"], name
        plan = ada.call("plan", action="fly", vehicle="rov", points_m=[[0, 0, -2]])
        assert plan["message"] == "autopilot: refused: the exercise does not allow this aid"
        hold = ada.call("command", name="hold", vehicle="rov", args={"depth": True})
        assert hold["message"] == "hold: refused: the exercise does not allow this aid"
        assert ada.call("command", name="hold", vehicle="rov", args={})["success"], "ending holds is no aid"
        assert ada.call("control", action="begin")["message"].startswith("begin: the attempt has begun")
        state = ada.call("exercise")
        assert state["has_begun"] and state["is_valid"] and state["aids"] == []


def test_allowed_aids_are_counted_in_seconds_and_cost_their_points(tmp_path):
    aids = Aid(kind="hold", cost_per_s=0.5), Aid(kind="autopilot"), Aid(kind="program")
    with attempt(tmp_path, hover(*aids, time_s=20.0)) as (station, _, ada):
        running = station.present()
        assert ada.call("command", name="hold", vehicle="rov", args={"depth": True})["success"]
        with running.live.privileged():
            running.live.speed = 4.0
        until(lambda: running.live.time_ns > 4e9, "four seconds")
        assert ada.call("command", name="hold", vehicle="rov", args={})["success"]
        assert ada.call("plan", action="fly", vehicle="rov", points_m=[[0, 0, -2.5]])["success"]
        until(lambda: running.plan.is_on, "a plan")
        planned_ns = running.live.time_ns
        until(lambda: running.live.time_ns > planned_ns + 1e9, "a second of it")
        ada.call("plan", action="stop")
        ada.call("hand_over", to="")
        with Bridge("test", running.live, running.table.channels, running.table.services) as bridge:
            assert bridge.respond(bridge.services["set_wrench"], {"force_body_n": [5.0, 0.0, 0.0]})["success"]
        with running.live.privileged():
            running.live.speed = 20.0
        score = score_of(station)
    used = {aid["kind"]: aid for aid in score["aids"]}
    assert 2.0 < used["hold"]["used_s"] < 15.0 and used["hold"]["cost"] == 0.5 * used["hold"]["used_s"]
    assert score["lost"] == pytest.approx(used["hold"]["cost"] + sum(each["cost"] for each in score["broken"]))
    assert used["autopilot"]["used_s"] > 0.0 and used["program"]["used_s"] > 0.0
    assert score["is_valid"], "what is allowed is counted, and costs its points"
    assert [(act["by"], act["text"]) for act in score["outside_acts"]] == [("a program", "/set_wrench")]
    page_text = (station.sessions.folder / "sheet-1/sheet.html").read_text()
    assert f"allowed, used for {used['hold']['used_s']:.1f} s" in page_text and "/set_wrench" in page_text


def test_an_attempt_in_a_changed_world_is_not_valid_and_the_next_one_is(tmp_path):
    with attempt(tmp_path) as (station, _, ada):
        live = station.present().live
        with live.privileged():
            live.command("inject_fault", kind="sonar").result()
        because = "the world was changed by the program that runs the simulator"
        assert ada.call("exercise")["invalid_because"] == because
        assert ada.call("control", action="restart")["success"]
        score = score_of(station)
        state = ada.call("exercise")
        assert state["attempt"] == 2 and state["is_valid"] and not state["has_begun"]
    assert not score["is_valid"] and not score["has_passed"]
    (act,) = score["outside_acts"]
    assert (act["by"], act["changed"]) == (because.rpartition(" by ")[2], True) and "sonar" in act["text"]


def test_a_sheet_that_cannot_be_written_is_reported_on_the_page(tmp_path, monkeypatch):
    monkeypatch.setattr("uwsim.exercises.sheet.sheet_html", Mock(side_effect=OSError("no space")))
    with attempt(tmp_path, hover(time_s=0.5)) as (_, _, ada):
        until(lambda: "no space" in ada.call("exercise")["error"], "the error on the page")


def test_an_attempt_is_of_the_person_who_began_it_and_has_a_sheet_if_the_server_ends(tmp_path):
    with attempt(tmp_path) as (station, server, ada), page(server, "Bob") as bob:
        until(lambda: station.present().live.tick > 20, "time")
        assert ada.call("exercise")["is_valid"]
        assert ada.call("hand_over", to=bob.id)["success"]
        until(lambda: not ada.call("exercise")["is_valid"], "another pilot")
    score = score_of(station)
    assert score["person"] == "Ada" and score["invalid_because"] == "Bob had the controls, too"
    assert score["ended_because"] == "broken off: the simulator was stopped" and score["time_s"] > 0.1
    assert (tmp_path / "sheet-1/sheet.html").is_file()


def test_an_all_stop_of_another_is_listed_and_is_no_aid(tmp_path):
    """Anyone may stop a vehicle; the sheet lists each outside act."""
    with attempt(tmp_path, hover(time_s=5.0)) as (station, server, _), page(server, "Bob") as bob:
        running = station.present()
        with Bridge("test", running.live, running.table.channels, running.table.services) as bridge:
            assert bridge.respond(bridge.services["all_stop"], {"data": True})["success"]
        assert bob.call("all_stop", vehicle="rov", on=True)["success"]
        with running.live.privileged():
            running.live.speed = 20.0
        score = score_of(station)
    acts = [(act["by"], act["text"], act["changed"]) for act in score["outside_acts"]]
    assert acts == [("a program", "/all_stop", False), ("Bob", "all stop", False)]
    assert score["is_valid"] and score["aids"] == []


def test_before_begin_nothing_is_judged_and_quitting_leaves_no_sheet(tmp_path):
    with serving(tmp_path, is_fixed=True, truth=False) as (station, server), page(server) as ada:
        station.run_exercise(hover())
        time.sleep(0.3)
        state = ada.call("exercise")
        assert not state["has_begun"] and state["time_s"] == 0.0 and station.present().live.tick == 0
    assert not list(tmp_path.glob("sheet-*"))


def test_an_events_command_is_no_outside_act_and_a_recorded_exercise_is_replayed(tmp_path):
    """The approach's current begins at time 0, by the exercise itself, and the score stays valid."""
    short = load_exercise("approach").model_copy(update={"time_s": 1.0})
    with attempt(tmp_path, short, keep_flights=Bounds(5, 100)) as (station, _, ada):
        ada.call("drive", vehicle="rov", surge=0.5)
        score = score_of(station)
        assert station.present().live.simulator.parameters["water.current_world_m_s"][1] == pytest.approx(0.1)
    assert (score["log"][0]["kind"], score["log"][0]["time_s"]) == ("event", 0.0)
    assert score["is_valid"] and score["outside_acts"] == []
    (flight,) = (tmp_path / "flights").glob("*.mcap")
    (listed,) = station.sessions.flights.listed()
    assert (listed["name"], listed["exercise"]) == (score["recording"], short.title) == (flight.name, short.title)
    again = replay(flight)
    assert again.difference is None and again.state_compared and again.commands >= 2, "the event, and the pilot's"
