"""A live simulator over rosbridge: as a server, as a client of another server, and from the command line."""

import pytest

from client_socket import call, receive, send
from client_socket import connect as websocket
from uwsim.bridges import RosbridgeClient, RosbridgeServer
from uwsim.bridges.cli.serve import parsed_speed
from uwsim.channels import Table
from uwsim.live import LiveSimulator
from waiting import until


@pytest.fixture(scope="module")
def live():
    with LiveSimulator("pool", speed=5.0) as live:
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
        assert {"/key", "/depthArray", "/cmd_vel", "/tf"} <= set(call(client, "/rosapi/topics")[1]["topics"])


def test_a_latched_topic_that_is_read_once_reaches_both_of_two(live):
    with RosbridgeServer(live) as server, websocket(server.url) as one, websocket(server.url) as two:
        for client in (one, two):
            send(client, "subscribe", topic="/tf_static", type="tf2_msgs/TFMessage")
            children = {t["child_frame_id"] for t in receive(client, op="publish")["msg"]["transforms"]}
            assert "odom" in children


def test_services_and_commands_act_and_what_they_refuse_is_said(live):
    with RosbridgeServer(live) as server, websocket(server.url) as client:
        assert call(client, "/release")[0] is True
        send(client, "publish", topic="/key", msg={"position": {"x": 4.0}})  # above 1: saturates
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
                assert call(peer, "/release")[0] is True
            broker.stop()
            if turn == 0:
                broker = RosbridgeServer(None, port=port).start()
                until(lambda: client.connections == 2 and client.connected.is_set())


def test_wrong_options_are_named(live):
    for options, complaint in (
        ({"wire": "copper"}, "wire = 'copper': must be"),
        ({"origin": "moon"}, "origin = 'moon': must be"),
    ):
        with pytest.raises(ValueError, match=complaint):
            RosbridgeServer(live, **options)
    with pytest.raises(ValueError, match="--speed = 'fast': must be a number, or max"):
        parsed_speed("fast")
