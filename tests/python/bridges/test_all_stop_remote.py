"""All stop from outside: rosbridge, ROS 2, Foxglove, a modem, a remote mission and the pilot's terminal."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import Any

import pytest
from websockets.sync.client import ClientConnection

from client_socket import call, connect, receive, send
from station_pages import page, serving
from uwsim import Simulator
from uwsim.bridges import RosbridgeServer
from uwsim.bridges.bridge import Bridge
from uwsim.bridges.remote import RemoteConnection, RemoteVehicle
from uwsim.bridges.ros2.service_topics import service_channels
from uwsim.channels import Table
from uwsim.channels.channel import Service
from uwsim.channels.families.telemetry import telemetry_channels
from uwsim.channels.ros import build
from uwsim.channels.ros.own_types import ALL_STOPPED
from uwsim.link import Carrier
from uwsim.link.packing import PACKINGS
from uwsim.link.remote import TOPIC
from uwsim.live import LiveSimulator
from uwsim.operator.teleop.app import Screen
from uwsim.operator.teleop.connection import Connection
from uwsim.operator.teleop.hands import Hands
from waiting import until

PATIENCE_S = 180.0
AHEAD = {"position": {"x": 1.0, "y": 0.0, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 0.0}}


def stop(client: ClientConnection, on: bool) -> Any:
    return call(client, "/all_stop", data=on)[1]


@pytest.fixture
def live() -> Iterator[LiveSimulator]:
    with LiveSimulator("pool") as live:
        live.rov.undock()
        yield live


@pytest.fixture
def server(live: LiveSimulator) -> Iterator[RosbridgeServer]:
    with RosbridgeServer(live) as server:
        yield server


def test_any_client_of_a_rosbridge_stops_what_another_drives(live: LiveSimulator, server: RosbridgeServer) -> None:
    with connect(server.url) as one, connect(server.url) as other:
        send(one, "publish", topic="/key", msg=AHEAD)
        until(lambda: live.rov.effort[0] == 1.0)
        for _ in range(2):
            assert stop(other, True) == {"success": True, "message": ""}
            assert live.rov.all_stopped and not live.rov.effort.any()
        for topic, message in (("/key", AHEAD), ("/cmd_vel", {"linear": {"x": 0.5}})):
            send(one, "publish", topic=topic, msg=message)
            assert "all stop is set" in receive(one, op="status")["msg"]
        assert not live.rov.effort.any()
        assert stop(other, False)["success"]
        send(one, "publish", topic="/key", msg=AHEAD)
        until(lambda: live.rov.effort[0] == 1.0)


def test_at_the_station_anybody_stops_and_the_pilot_releases() -> None:
    with serving() as (station, server), page(server) as ada, page(server, "Bob") as bob:
        ada.call("start", scenario="pool", speed=5)
        ada.call("take_control")
        live = station.present().live
        assert ada.call("drive", vehicle="rov", surge=1.0)["success"]
        assert bob.call("all_stop", vehicle="rov")["success"]
        assert live.rov.all_stopped and not live.rov.effort.any()
        assert ada.call("all_stop", vehicle="rov")["success"], "once more is no release"
        assert "all stop is set" in ada.call("drive", vehicle="rov", surge=0.5)["message"]
        assert "Ada has the controls" in bob.call("all_stop", vehicle="rov", on=False)["message"]
        assert "must be one of" in ada.call("command", name="all_stop", vehicle="rov")["message"]
        assert live.rov.all_stopped
        assert ada.call("all_stop", vehicle="rov", on=False)["success"] and not live.rov.all_stopped
        assert ada.call("drive", vehicle="rov", surge=0.5)["success"] and live.rov.effort[0] == 0.5


def test_it_does_not_wait_for_other_calls(live: LiveSimulator) -> None:
    going_on = threading.Event()
    busy = [
        Service(f"busy_{k}", "std_srvs/srv/Trigger", lambda live, request: {"success": going_on.wait(PATIENCE_S)})
        for k in range(8)
    ]
    offered = [*Table(live.simulator).services, *busy]
    with RosbridgeServer(None) as server, connect(server.url) as socket:
        server.show(live, [], offered)
        until(lambda: "/all_stop" in call(socket, "/rosapi/services")[1]["services"])
        for service in busy:
            send(socket, "call_service", service=f"/{service.name}", id=service.name)
        try:
            assert stop(socket, True)["success"] and live.rov.all_stopped
        finally:
            going_on.set()
    going_on.clear()
    answers: list[str] = []
    with Bridge("test", live, [], offered) as bridge:
        said = service_channels(offered, bridge.call, lambda level, text: answers.append(text))
        topics = {channel.name: channel for channel in said}
        for service in busy:
            topics[service.name].apply(live, build.message("std_msgs/msg/Empty"))
        try:
            topics["all_stop"].apply(live, build.message("std_msgs/msg/Bool", data=False))
            until(lambda: any(answer.startswith("/all_stop") for answer in answers))
            assert not live.rov.all_stopped
        finally:
            going_on.set()


def test_a_remote_vehicle_is_stopped_and_says_so(live: LiveSimulator, server: RosbridgeServer) -> None:
    with RemoteConnection(server.url) as connection:
        far = RemoteVehicle(connection)
        assert not far.all_stopped
        far.all_stop()
        until(lambda: far.all_stopped)
        far.set_effort(surge=1.0)
        far.all_stop(False)  # sent on the same connection after the effort, so it arrives after it
        until(lambda: not far.all_stopped)
        assert not live.rov.effort.any()


# Over a modem


@pytest.mark.parametrize("modem", ["tether", "ideal_acoustic", "s2cm_hs"])
def test_it_crosses_a_link_as_urgently_as_can_be(modem: str) -> None:
    sim = Simulator("pool", link=modem)
    table = Table(sim)
    with LiveSimulator(sim, paused=True, speed="max") as live, Carrier(live, table) as carrier:
        stop = next(one for one in carrier.over(table.services) if one.name == "all_stop")
        live.rov.undock()
        live.rov.set_effort(surge=1.0)
        assert stop.call(live, {"data": True}).result() == {"success": True, "message": f"sent over {modem}"}
        assert not live.rov.all_stopped, "it takes its time"
        live.step(2000)
        assert live.rov.all_stopped and not live.rov.effort.any()
        assert stop.call(live, {"data": False}).result()["success"]
        live.step(2000)
        assert not live.rov.all_stopped
        given = [entry.arguments for entry in live.log if entry.arguments.get("topic") == TOPIC + "all_stop"]
        assert [(one["priority"], one["replaces"]) for one in given] == [(0, True)] * 2
        assert [one["lifetime_s"] is None for one in given] == [True, False], "a stop is sent however late"
        assert [one["repeats"] for one in given] == [2, 0]


@pytest.mark.parametrize("packing", ["telemetry", "telemetry_short"])
@pytest.mark.parametrize("is_stopped", [False, True])
def test_the_panel_over_a_modem_tells_it(packing: str, is_stopped: bool) -> None:
    sim = Simulator("pool")
    sim.rov.all_stop(is_stopped)
    (channel,) = telemetry_channels(Table(sim).sources[0], sim, truth=True)
    data = PACKINGS[packing].pack(channel.read(sim))
    assert list(PACKINGS[packing].unpack(data, channel).alarms) == [ALL_STOPPED] * is_stopped


# The pilot's terminal


def test_x_in_the_terminal_stops_and_capital_x_releases(live: LiveSimulator, server: RosbridgeServer) -> None:
    connection = Connection(server.url, Hands())
    app = Screen(connection)
    said: list[str] = []
    connection.report = said.append
    connection.start()
    try:
        until(lambda: connection.state == "connected")
        with connect(server.url) as other:
            send(other, "publish", topic="/key", msg=AHEAD)
            until(lambda: live.rov.effort[0] == 1.0)
            app.press("x")
            app.press("x")  # keyboard auto-repeat
            until(lambda: live.rov.all_stopped and not live.rov.effort.any())
            until(lambda: connection.readout.all_stop)
            assert "ALL STOP: X releases it" in app.text(80)
            app.press("w")
            until(lambda: any("all stop is set" in text for text in said))
            assert not live.rov.effort.any()
            app.press("X")
            until(lambda: not live.rov.all_stopped)
            assert not live.rov.effort.any(), "the keys are let go"
            until(lambda: not connection.readout.all_stop)
            app.press("w")
            until(lambda: live.rov.effort[0] == 0.5)
    finally:
        connection.stop()


def test_an_all_stop_without_a_connection_is_sent_as_soon_as_there_is_one(live: LiveSimulator) -> None:
    with RosbridgeServer(live) as server:
        port = server.port
    connection = Connection(f"ws://127.0.0.1:{port}", Hands())
    said: list[str] = []
    connection.report = said.append
    connection.start()
    try:
        until(lambda: said)
        connection.all_stop(on=True)
        assert not live.rov.all_stopped
        with RosbridgeServer(live, port=port):
            until(lambda: live.rov.all_stopped)
    finally:
        connection.stop()
