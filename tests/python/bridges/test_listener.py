"""A listening server answers or disconnects unknown clients, and logs one line per kind of error, no traceback."""

import asyncio
import json
import logging
import socket
from collections.abc import Iterator
from contextlib import ExitStack

import cbor2
import pytest
from websockets.exceptions import ConnectionClosedOK

from client_socket import connect
from uwsim.bridges import RosbridgeServer, rare_log
from uwsim.bridges.doors import connection, places
from uwsim.bridges.doors.conversation import Rates, Share, converse
from uwsim.bridges.doors.places import HALF_OPEN_MAX
from uwsim.bridges.rare_log import RareLog
from uwsim.bridges.rosbridge import Limits
from waiting import until

PATIENCE_S = 180.0
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
    monkeypatch.setattr(places, "HALF_OPEN_S", 0.5)
    monkeypatch.setattr(connection, "HALF_OPEN_S", 0.5)
    with ExitStack() as stack:
        strangers = [
            stack.enter_context(socket.create_connection(("127.0.0.1", server.port)))
            for _ in range(PLACES + HALF_OPEN_MAX + 20)
        ]
        strangers[0].sendall(b"GET / HTTP/1.1\r\nHost: loc")
        until(lambda: all(map(cut_off, strangers)))
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
    messages = [record.getMessage() for record in caplog.records if record.name == "uwsim.test"]
    assert messages[:3] == ["no file left", "another", "no file left (and 499 times before)"]
    assert len(messages) <= rare_log.KINDS_MAX + 2


class Frames:
    """A connection that receives some frames and then ends, and its session, which takes cpu_s for each."""

    def __init__(self, count: int, cpu_s: float) -> None:
        self._left, self._cpu_s = count, cpu_s

    async def recv(self) -> str:
        if not self._left:
            raise ConnectionClosedOK(None, None)
        self._left -= 1
        return "{}"

    async def take(self, frame: str | bytes) -> float:
        return self._cpu_s

    async def next_frame(self) -> tuple[None, None]:
        return None, None


@pytest.mark.parametrize(("cpu_s", "waits"), [(1e-4, False), (0.1, True)])
def test_only_who_takes_more_than_an_equal_part_waits_for_others(
    cpu_s: float, waits: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    delays_s: list[float] = []

    async def sleep(delay_s: float) -> None:
        delays_s.append(delay_s)

    share, frames = Share(0.3), Frames(20, cpu_s)
    share.clients = 9
    share.delay_after(100.0)  # taken by the others
    monkeypatch.setattr("uwsim.bridges.doors.conversation.asyncio.sleep", sleep)
    asyncio.run(converse(frames, frames, asyncio.Event(), Rates(1e3, 1e6), share))  # type: ignore[arg-type]
    assert (max(delays_s) > 0) == waits and share.clients == 9


class Broken(Frames):
    """A client that reads for ever, and whose next frame cannot be made."""

    async def recv(self) -> str:
        await asyncio.Event().wait()
        return ""

    async def next_frame(self) -> tuple[None, None]:
        raise ArithmeticError("no such frame")


def test_a_client_that_can_be_sent_nothing_more_is_not_left_to_wait() -> None:
    share, frames = Share(0.3), Broken(1, 0.0)
    with pytest.raises(ArithmeticError, match="no such frame"):
        asyncio.run(converse(frames, frames, asyncio.Event(), Rates(1e3, 1e6), share))  # type: ignore[arg-type]
    assert share.clients == 0
