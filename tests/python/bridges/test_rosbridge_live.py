"""A live simulator over rosbridge: as a server, as a client of another server, and from the command line."""

import re
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from client_socket import connect as websocket
from client_socket import receive, send
from uwsim.bridges import RosbridgeClient, RosbridgeServer
from uwsim.bridges.cli.serve import parsed_speed
from uwsim.channels import Table
from uwsim.live import LiveSimulator
from waiting import until

PATIENCE_S = 20.0
UWSIM = Path(sys.executable).with_name("uwsim")


@pytest.fixture(scope="module")
def live():
    with LiveSimulator("lake", speed=5.0) as live:
        yield live


def test_topics_are_read_while_somebody_listens_and_stamped_with_simulated_time(live):
    with RosbridgeServer(live) as server, websocket(server.url) as client:
        send(client, "subscribe", topic="/scan", type="sensor_msgs/LaserScan")
        first, second = receive(client, op="publish")["msg"], receive(client, op="publish")["msg"]
        assert len(first["ranges"]) == live.simulator.rov.sonar.model.beams
        times = [scan["header"]["stamp"]["secs"] + 1e-9 * scan["header"]["stamp"]["nsecs"] for scan in (first, second)]
        assert 0.0 <= times[0] <= times[1] <= live.simulator.time_s
        node = next(iter(server.graph.topics["scan"].publishers))
        assert node == "/uwsim"
        send(client, "unsubscribe", topic="/scan")
        send(client, "call_service", service="/rosapi/topics", id="all")
        assert {"/key", "/depthArray", "/cmd_vel", "/tf"} <= set(receive(client, id="all")["values"]["topics"])


def test_a_latched_topic_that_is_read_once_reaches_both_of_two(live):
    with RosbridgeServer(live) as server, websocket(server.url) as one, websocket(server.url) as two:
        for client in (one, two):
            send(client, "subscribe", topic="/tf_static", type="tf2_msgs/TFMessage")
            children = {t["child_frame_id"] for t in receive(client, op="publish")["msg"]["transforms"]}
            assert "odom" in children


def test_services_and_commands_act_and_what_they_refuse_is_said(live):
    with RosbridgeServer(live) as server, websocket(server.url) as client:
        send(client, "call_service", service="/release", id="1")
        assert receive(client, id="1")["result"] is True
        send(client, "publish", topic="/key", msg={"position": {"x": 4.0}})  # above 1: saturates
        send(client, "call_service", service="/rosapi/get_time", id="2")
        receive(client, id="2")
        until(lambda: live.simulator.rov.effort[0] == 1.0)
        send(client, "publish", topic="/cmd_vel", id="bad", msg={"linear": {"x": None}})  # NaN
        assert "cmd_vel" in receive(client, op="status", id="bad")["msg"]
        send(client, "publish", topic="/key", msg={})


def test_a_client_that_asks_for_nothing_costs_the_simulator_nothing(live):
    with RosbridgeServer(live) as server:
        assert server.sessions == {}
        node = server.graph.topics["scan"]
        assert node.sinks == {} and node.publishers == {"/uwsim": False}


def test_a_simulator_joins_a_rosbridge_and_comes_back_when_it_was_away(live):
    table = Table(live.simulator, wire="published")
    broker = RosbridgeServer(None).start()
    port = broker.port
    with RosbridgeClient(live, broker.url, channels=table.channels, services=table.services) as client:
        for turn in range(2):
            with websocket(broker.url) as peer:
                send(peer, "subscribe", topic="/depthArray", type="std_msgs/String")
                text = receive(peer, op="publish", topic="/depthArray")["msg"]["data"]
                assert text.count("a") == live.simulator.rov.sonar.model.beams
                send(peer, "publish", topic="/key", msg={"position": {"x": 0.25 * (turn + 1)}})
                until(lambda effort=0.25 * (turn + 1): live.simulator.rov.effort[0] == effort)
                send(peer, "call_service", service="/release", id="r")
                assert receive(peer, id="r")["result"] is True
            broker.stop()
            if turn == 0:
                broker = RosbridgeServer(None, port=port).start()
                until(lambda: client.connections == 2 and client.connected.is_set())


def test_a_client_needs_a_websocket_url(live):
    with pytest.raises(ValueError, match="url = 'localhost': must begin with ws://"):
        RosbridgeClient(live, "localhost", channels=())


def test_uwsim_serve_and_connect_end_at_ctrl_c():
    serve = [UWSIM, "serve", "lake", "--port", "0", "--paused", "--wire", "published"]
    with subprocess.Popen(serve, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as server:
        watchdog = threading.Timer(60.0, server.kill)
        watchdog.start()
        try:
            line = server.stdout.readline()
            url = re.search(r"ws://127\.0\.0\.1:\d+", line)[0]
            assert "paused; Ctrl-C ends it" in line
            with websocket(url) as client:
                send(client, "call_service", service="/rosapi/topics", id="t")
                assert set(receive(client, id="t")["values"]["topics"]) >= {"/propPos", "/depthArray"}
            server.send_signal(signal.SIGINT)
            assert server.wait(PATIENCE_S) == 0
            assert server.stderr.read() == ""
        finally:
            watchdog.cancel()
            server.kill()


def test_wrong_options_are_named(live):
    for options, complaint in (
        ({"port": 99999}, "port = 99999: must be in"),
        ({"wire": "copper"}, "wire = 'copper': must be"),
        ({"origin": "moon"}, "origin = 'moon': must be"),
    ):
        with pytest.raises(ValueError, match=complaint):
            RosbridgeServer(live, **options)
    with pytest.raises(ValueError, match="--speed = 'fast': must be a number, or max"):
        parsed_speed("fast")
