"""`uwsim connect` from the shell: it waits for its server, joins it, and reconnects after an outage."""

import logging
import signal
import subprocess
import sys
import threading
import time
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path

import pytest
from websockets.sync.server import serve

from client_socket import connect as websocket
from client_socket import receive, send
from command_line import error_line, uwsim
from uwsim.bridges import RosbridgeClient, RosbridgeServer
from uwsim.bridges.nodes.websocket import checked_url
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.channels import Channel
from uwsim.channels.ros.messages import default_message
from uwsim.live import LiveSimulator
from waiting import until

PATIENCE_S = 60.0
UWSIM = Path(sys.executable).with_name("uwsim")


def answer(client, service, **args):
    """Call a service, retrying until it is available."""
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline:
        send(client, "call_service", service=service, id=service, args=args)
        response = receive(client, op="service_response", id=service)
        if response["result"]:
            return response["values"]
        time.sleep(0.05)
    raise TimeoutError(service)


@pytest.fixture
def port():
    with RosbridgeServer(None) as server:
        return server.port


def test_it_joins_a_server_that_comes_later_and_again_one_that_was_killed(port):
    url = f"ws://127.0.0.1:{port}"
    command = [UWSIM, "connect", url, "pool", "--speed", "2"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        watchdog = threading.Timer(2 * PATIENCE_S, process.kill)
        watchdog.start()
        try:
            assert url in process.stdout.readline()
            assert "next attempt in 0.25 s" in process.stderr.readline()  # no server is listening yet
            for turn in range(2):
                with RosbridgeServer(None, port=port) as server, websocket(server.url) as peer:
                    assert answer(peer, "/simulation/pace")["speed"] == 2.0
                    send(peer, "subscribe", topic="/modelTrigger", type="std_msgs/String")  # latched
                    assert receive(peer, op="publish", topic="/modelTrigger")["msg"]["data"] == "2"
                    send(peer, "subscribe", topic="/propPos", type="geometry_msgs/Pose")
                    start = receive(peer, op="publish", topic="/propPos")["msg"]["position"]
                    if turn == 0:
                        assert answer(peer, "/release")["success"]
                    way = 1.0 - 2.0 * turn
                    send(peer, "publish", topic="/key", msg={"position": {"x": way}})
                    while (
                        receive(peer, op="publish", topic="/propPos")["msg"]["position"]["x"] - start["x"]
                    ) * way < 0.1:
                        pass
            process.send_signal(signal.SIGINT)
            said = process.communicate(timeout=PATIENCE_S)[1]
            assert process.returncode == 0
            assert said.count(": connected") == 2
            assert "Traceback" not in said
        finally:
            watchdog.cancel()
            process.kill()


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
                assert "Port out of range" in client.trouble
        finally:
            server.shutdown()
            thread.join()


def test_a_server_that_ends_each_connection_is_asked_less_and_less_often(monkeypatch, caplog):
    caplog.set_level(logging.INFO, "uwsim.rosbridge")
    monkeypatch.setattr("uwsim.bridges.rosbridge.client.FIRST_WAIT_S", 0.01)
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
    ("arguments", "complaint"),
    [
        (["localhost:9090", "pool"], "url = 'localhost:9090': must begin with ws://"),
        (["ws://localhost:9090", "pool", "--ros", "3"], "--ros = 3: must be in [1, 2]"),
        (["ws://localhost:9090", "pool", "--wire", "copper"], "--wire = 'copper': must be one of"),
        (["ws://localhost:9090", "pool", "--tf-rate", "5000"], "tf_rate_hz = 5000 Hz: must be in (0, "),
    ],
)
def test_mistakes_are_one_line(arguments, complaint):
    done = uwsim("connect", *arguments)
    assert done.returncode == (2 if complaint.startswith("--") else 1)
    assert complaint in error_line(done)
