"""A listening server answers or disconnects unknown clients, and logs one line per kind of error, no traceback."""

import json
import logging
import socket
import time
from collections.abc import Iterator
from contextlib import ExitStack

import cbor2
import pytest

from client_socket import connect
from uwsim.bridges import RosbridgeServer, connection, rare_log
from uwsim.bridges.listener import HALF_OPEN_MAX
from uwsim.bridges.rare_log import RareLog
from uwsim.bridges.rosbridge import Limits

PATIENCE_S = 60.0
PLACES = 4
LAST = '{"op": "call_service", "service": "/rosapi/topics", "id": "last"}'


@pytest.fixture(scope="module")
def server() -> Iterator[RosbridgeServer]:
    with RosbridgeServer(None, limits=Limits(connections=PLACES)) as server:
        yield server


def cut_off(stranger: socket.socket) -> bool:
    """Return True if the server has closed the connection."""
    stranger.setblocking(False)
    try:
        return stranger.recv(1) == b""
    except BlockingIOError:
        return False
    except ConnectionError:
        return True


@pytest.mark.parametrize(
    "frame",
    [
        '{"op":"nope","x":NaN,"id":1' + "0" * 30 + "}",
        '{"op":"nope","id":"\\ud800","x":NaN}',
        '{"op":"call_service","service":"/\\ud800","x":NaN}',
        '{"op":"subscribe","topic":"/a","type":"std_msgs/String","throttle_rate":1e400,"x":NaN}',
        cbor2.dumps({"op": "nope", "id": -(2**64)}),
        cbor2.dumps({"op": "call_service", "service": "/rosapi/topics", "id": -(2**64)}),
    ],
)
def test_an_answer_that_cannot_be_written_is_an_error_in_one_line(
    server: RosbridgeServer, frame: str | bytes, caplog: pytest.LogCaptureFixture
) -> None:
    with connect(server.url, compression=None) as client:
        client.send(frame)
        client.send(LAST)
        answer = client.recv(PATIENCE_S)
        assert "\n" not in str(answer) and '"last"' not in str(answer)
        assert json.loads(client.recv(PATIENCE_S))["id"] == "last"
    assert not [record for record in caplog.records if record.levelno >= logging.ERROR]


def test_half_open_connections_are_bounded_and_leave_room_again(
    server: RosbridgeServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connection, "HEAD_S", 0.5)
    with ExitStack() as stack:
        strangers = [
            stack.enter_context(socket.create_connection(("127.0.0.1", server.port)))
            for _ in range(PLACES + HALF_OPEN_MAX + 20)
        ]
        strangers[0].sendall(b"GET / HTTP/1.1\r\nHost: loc")
        deadline_s = time.monotonic() + PATIENCE_S
        while not all(map(cut_off, strangers)):
            assert time.monotonic() < deadline_s
            time.sleep(0.05)
        with connect(server.url, compression=None) as client:
            client.send(LAST)
            assert json.loads(client.recv(PATIENCE_S))["result"]


def test_a_warning_of_each_kind_is_logged_once_a_minute(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    now_s = [1000.0]
    monkeypatch.setattr(rare_log.time, "monotonic", lambda: now_s[0])
    rare = RareLog(logging.getLogger("uwsim.test"))
    for _ in range(500):
        rare.warning("no file left")
    rare.warning("another")
    now_s[0] += rare_log.EVERY_S
    rare.warning("no file left")
    for k in range(2 * rare_log.KINDS_MAX):
        rare.warning(f"kind {k}")
    messages = [record.getMessage() for record in caplog.records]
    assert messages[:3] == ["no file left", "another", "no file left (and 499 times before)"]
    assert len(messages) <= rare_log.KINDS_MAX + 2
