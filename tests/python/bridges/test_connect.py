"""`uwsim ros connect` and `uwsim serve` from the shell.

connect waits for its server, joins it, and reconnects after an outage; serve and its sinks start and end together.
"""

import logging
import re
import signal
import threading
from http.server import BaseHTTPRequestHandler, HTTPServer

import pytest
from websockets.sync.server import serve

from client_socket import call, receive, send
from client_socket import connect as websocket
from command_line import error_line, uwsim
from foxglove_client import FoxgloveClient
from ros2_tools import free_domain, peer
from strict_rosbridge import strict_rosbridge
from uwsim.bridges import RosbridgeClient, RosbridgeServer
from uwsim.bridges.doors.dialler import checked_url
from uwsim.bridges.ros2 import Ros2Settings
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.channels import Channel
from uwsim.channels.ros.messages import default_message
from uwsim.live import LiveSimulator
from waiting import until


@pytest.fixture
def port():
    with RosbridgeServer(None) as server:
        return server.port


def test_it_joins_a_server_that_comes_later_and_again_one_that_was_killed(port, programs):
    url = f"ws://127.0.0.1:{port}"
    with programs.running("ros", "connect", url, "pool", "--speed", "2") as process:
        assert url in process.stdout.readline()
        assert "next attempt in 0.25 s" in process.stderr.readline()  # no server is listening yet
        for turn in range(2):
            with RosbridgeServer(None, port=port) as server, websocket(server.url) as peer:
                pace = until(lambda peer=peer: values if (values := call(peer, "/simulation/pace"))[0] else None)
                assert pace[1]["speed"] == 2.0
                send(peer, "subscribe", topic="/modelTrigger", type="std_msgs/String")  # latched
                assert receive(peer, op="publish", topic="/modelTrigger")["msg"]["data"] == "2"
                send(peer, "subscribe", topic="/propPos", type="geometry_msgs/Pose")
                start = receive(peer, op="publish", topic="/propPos")["msg"]["position"]
                if turn == 0:
                    assert call(peer, "/release")[1]["success"]
                way = 1.0 - 2.0 * turn
                send(peer, "publish", topic="/key", msg={"position": {"x": way}})
                while (receive(peer, op="publish", topic="/propPos")["msg"]["position"]["x"] - start["x"]) * way < 0.1:
                    pass
        code, said = process.end(signal.SIGINT)
    assert code == 0 and said.count(": connected") == 2 and "Traceback" not in said


def test_it_ends_with_an_error_if_the_server_refused_everything(programs):
    with strict_rosbridge() as server:
        server.packages = {"rosgraph_msgs"}
        with programs.running("ros", "connect", server.url, "pool") as process:
            server.wait(lambda: any("advertise" in line for line in server.refused))
            while "the server refuses" not in process.stderr.readline():
                pass
            code, said = process.end(signal.SIGINT)
        assert code == 1 and "Traceback" not in said
        assert f"error: {server.url}: the server refuses" in said


def test_serve_ends_at_ctrl_c(programs):
    words = ["serve", "pool", "--port", "0", "--paused", "--wire", "published"]
    with programs.greeted(*words) as (process, line):
        assert "paused; Ctrl-C ends it" in line
        with websocket(re.search(r"ws://127\.0\.0\.1:\d+", line)[0]) as client:
            assert set(call(client, "/rosapi/topics")[1]["topics"]) >= {"/propPos", "/depthArray"}
        assert process.end(signal.SIGINT) == (0, "")


def test_serve_is_a_node_of_ros_2_and_serves_foxglove_until_it_is_ended(programs):
    settings = Ros2Settings(domain_id=free_domain())
    words = ["serve", "pool", "--port", "0", "--ros2", "--ros-domain-id", str(settings.domain_id), "--foxglove"]
    with programs.greeted(*words, "--foxglove-port", "0") as (program, greeting):
        assert f"ROS 2 jazzy, domain {settings.domain_id}, on this machine alone" in greeting
        url = re.search(r"Foxglove at (ws://\S+:\d+)", greeting)
        assert url is not None, greeting
        with peer(settings) as other, FoxgloveClient(url[1]) as client:
            other.listen("clock", "rosgraph_msgs/msg/Clock")
            client.subscribe("/clock")
            assert other.next("clock").clock.sec >= 0
            assert client.next("/clock")[0] >= 0
        assert program.end()[0] == 0


def test_messages_that_a_server_finds_too_large_are_left_out_and_said_once(caplog):
    def said(name, size):
        message = default_message("std_msgs/msg/String")
        message.data = size * "x"
        return Channel(name, "std_msgs/msg/String", "out", "", rate_hz=20.0, read=lambda sim: message)

    told = [said("small", 100), said("large", 5000), said("huge", 9000)]
    limits = Limits(frame_bytes=3000)
    with (
        LiveSimulator("pool") as live,
        RosbridgeServer(None, limits=limits) as server,
        websocket(server.url) as peer,
        RosbridgeClient(live, server.url, channels=told),
    ):
        send(peer, "subscribe", topic="/small", type="std_msgs/String")
        until(lambda: caplog.text.count("too large, left out") >= 2 and live.running)
        for _ in range(20):
            receive(peer, op="publish", topic="/small")
    assert caplog.text.count("topic 'large': messages of") == 1
    assert caplog.text.count("topic 'huge': messages of") == 1


def test_a_server_that_redirects_to_no_address_is_reported_and_tried_again():
    asked = []

    class Redirect(BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def do_GET(self):
            asked.append(self.path)
            self.send_response(301)
            self.send_header("Location", "ws://127.0.0.1:99999/")
            self.send_header("Content-Length", "0")
            self.send_header("Connection", "close")
            self.end_headers()

        def log_message(self, *args):
            pass

    with HTTPServer(("127.0.0.1", 0), Redirect) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        try:
            with RosbridgeClient(LiveSimulator("pool"), f"ws://127.0.0.1:{server.server_port}", channels=[]) as client:
                until(lambda: len(asked) > 1, "another attempt")
                assert "Port out of range" in client.client.trouble
        finally:
            server.shutdown()
            thread.join()


def test_a_server_that_ends_each_connection_is_asked_less_and_less_often(monkeypatch, caplog):
    caplog.set_level(logging.INFO, "uwsim.rosbridge")
    monkeypatch.setattr("uwsim.bridges.doors.dialler.FIRST_WAIT_S", 0.01)
    with serve(lambda connection: None, "127.0.0.1", 0) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            url = f"ws://127.0.0.1:{server.socket.getsockname()[1]}"
            with RosbridgeClient(LiveSimulator("pool"), url, channels=[]):
                until(lambda: "next attempt in 0.08 s" in caplog.text)
        finally:
            server.shutdown()
            thread.join()
    assert ": connected" not in caplog.text


@pytest.mark.parametrize("url", ["ws://", "ws://host:99999", "ws://[::1", f"ws://{70 * 'a'}:9090", "ws://host:x"])
def test_an_address_that_no_server_can_have_is_refused_at_once(url):
    with pytest.raises(ValueError, match="must have a host and a port"):
        checked_url(url)
    assert checked_url("wss://[::1]:9090/?token=a") == "wss://[::1]:9090/?token=a"


@pytest.mark.parametrize(
    ("arguments", "code", "complaint"),
    [
        ("ros connect localhost:9090 pool", 1, "url = 'localhost:9090': must begin with ws://"),
        ("ros connect ws://localhost:9090 pool --ros 3", 2, "--ros = 3: must be in [1, 2]"),
        ("ros connect ws://localhost:9090 pool --wire copper", 2, "--wire = 'copper': must be one of"),
        ("ros connect ws://localhost:9090 pool --tf-rate 5000", 1, "tf_rate_hz = 5000 Hz: must be in (0, "),
        ("serve pool --ros-domain-id 3", 2, "--ros-domain-id: needs --ros2"),
        ("serve pool --foxglove-port 3", 2, "--foxglove-port: needs --foxglove"),
        ("serve pool --ros2 --ros-domain-id 300", 2, "--ros-domain-id = 300: must be in [0, 232]"),
        ("serve pool --ros2 --ros-distro kinetic", 2, "must be one of humble, jazzy"),
    ],
)
def test_mistakes_are_one_line(arguments, code, complaint):
    done = uwsim(*arguments.split())
    assert done.returncode == code and complaint in error_line(done)
