"""Changes at a station: simulators prepared before Start, pilots whose network fails, parameter updates to pages."""

import time
from itertools import pairwise
from pathlib import Path

import pytest
from websockets.sync.client import connect

from browser import until
from station_pages import Page, page, serving
from uwsim import Simulator
from uwsim.live import LiveSimulator
from uwsim.operator.station.controls.plan import Plan, PlanFlight
from uwsim.operator.station.services import services
from uwsim.operator.station.services.control import new_path


def test_start_finds_the_simulator_that_was_checked_ready():
    with serving() as (station, server), page(server) as ada:
        prepared = station.sessions.prepared
        assert ada.call("check", scenario="pool", seed=4)["success"]
        until(lambda: prepared._made.done(), "a simulator")
        ready = prepared._made.result()
        assert ada.call("start", scenario="pool", seed=4)["success"]
        assert station.present().live.simulator is ready and prepared._made is None
        ada.call("check", scenario="pool", seed=5)
        assert prepared._made is None  # no second simulator is prepared while one runs


def test_nothing_stays_prepared_when_all_have_left_the_start_screen():
    with serving() as (station, server):
        with page(server) as ada:
            ada.call("check", scenario="pool")
            assert station.sessions.prepared._made is not None
        until(lambda: station.sessions.prepared._made is None, "nothing prepared")


def test_the_controls_of_a_pilot_whose_network_died_can_be_taken(monkeypatch):
    monkeypatch.setattr(services, "DEAD_S", 60.0)  # on a busy machine her replies are late
    with (
        serving() as (station, server),
        page(server, "Bob") as bob,
        connect(server.url, close_timeout=0.1) as socket,
    ):
        ada = Page(socket)
        ada.id = ada.call("join", name="Ada")["id"]
        assert ada.call("take_control")["success"]
        bob.subscribe("/station/state")

        def answers_pings():  # one a second; she sends no commands
            before_s = station.sessions.node.silence_s(ada.id)
            time.sleep(0.05)
            return station.sessions.node.silence_s(ada.id) < before_s

        until(answers_pings, "her reply to a ping")
        assert bob.message("/station/state", lambda s: s["pilot"] == ada.id and s["pilot_silence"] == 0.0)
        assert "Ada has the controls" in bob.call("take_control")["message"]
        monkeypatch.setattr(services, "DEAD_S", 1.4)
        socket.protocol.send_frame = lambda frame: None  # from now on nothing she sends arrives, including pongs
        assert bob.message("/station/state", lambda state: state["pilot_silence"] > 0.0)["pilot"] == ada.id
        until(lambda: bob.call("take_control")["success"], "the controls")


def test_a_fixed_station_offers_no_start_screen_and_its_description_follows_parameters():
    with serving(is_fixed=True) as (station, server), page(server) as ada:
        ada.subscribe("/station/state")
        assert ada.message("/station/state")["phase"] == "starting"
        station.run(lambda: LiveSimulator(Simulator("pool", sonar_model="em2040-04", sonar_frequency_hz=400e3)))
        offered = {service.name for service in station.services}
        assert not offered & {"station/catalog", "station/check", "station/start"}
        before = ada.call("describe")
        assert before["is_fixed"] and "quit" not in before["controls"] and "restart" in before["controls"]
        ada.call("take_control")
        assert "must be one of" in ada.call("control", action="quit")["message"]
        live = station.present().live
        live.call(lambda sim: sim.parameters.update({"rov.sonar.range_max_m": 12.0})).result()
        ada.message("/station/state", lambda state: state["edition"] > before["edition"])
        after = ada.call("describe")
        assert after["session"] == before["session"]
        assert (before["vehicles"][0]["sonar"]["range_m"] != 12.0) and after["vehicles"][0]["sonar"]["range_m"] == 12.0


def test_a_saved_plan_hides_no_module(tmp_path: Path):
    for name in ("numpy", "numpy.py", "json", "uwsim"):
        with pytest.raises(ValueError, match="a Python module has this name, which the file would hide"):
            new_path(tmp_path, {"name": name}, "plan", ".py")
    assert new_path(tmp_path, {"name": "my_plan"}, "plan", ".py") == tmp_path / "my_plan.py"


def test_time_stands_still_while_a_plan_decides():
    """Each control period of a plan has its command, at whatever speed the simulator runs."""
    with LiveSimulator(Simulator("pool", seed=2), speed="max") as live:
        live.pause()
        flight = PlanFlight(live, "rov", Plan([(-3.0, 0.0, -2.0), (-1.0, 1.0, -2.0)], 0.5))
        until(lambda: any(entry.name == "set_effort" for entry in live.log), "the plan's first command")
        live.resume()
        until(lambda: not flight.is_on, "the end of the plan")
        ticks = [entry.tick for entry in live.log if entry.name == "set_effort"]
        ended = live.tick
        until(lambda: live.tick > ended, "time to pass again")
        assert flight.report()["ended_because"] == "all waypoints are reached"
        assert len(ticks) > 30
        assert {later - earlier for earlier, later in pairwise(ticks[:-1])} == {round(0.1 / live.simulator.step_s)}
