"""Foxglove's protocol: exchanges match those of the SDK's server, are bounded, and are closed to foreign web pages."""

import gc
import json
import ssl
import struct
import time
import weakref
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import foxglove
import pytest
from foxglove.channels import SceneUpdateChannel
from foxglove.messages import SceneUpdate
from foxglove.websocket import Capability, MessageSchema, Parameter, ServiceSchema
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.frames import CloseCode
from websockets.sync.client import connect

from certificate import first_frame, write_certificate
from foxglove_client import FoxgloveClient
from ros2_tools import PATIENCE_S, until
from uwsim.bridges.doors.waiting import Room
from uwsim.bridges.foxglove import FoxgloveServer, outbox, protocol, session
from uwsim.bridges.foxglove.outbox import Outbox
from uwsim.bridges.foxglove.protocol import Call, Offer
from uwsim.bridges.foxglove.protocol import described as described_parameter
from uwsim.bridges.foxglove.session import Session
from uwsim.bridges.playback.feed import PlayedFeed
from uwsim.channels import Channel, Service, Table
from uwsim.live import LiveSimulator

TEXT = "std_msgs/msg/String"
TOKEN = "correct-horse"


@pytest.fixture(scope="module")
def live() -> Iterator[LiveSimulator]:
    with LiveSimulator("pool") as live:
        yield live


@pytest.fixture(scope="module")
def server(live: LiveSimulator) -> Iterator[FoxgloveServer]:
    table = Table(live.simulator)
    with FoxgloveServer(live, table.channels, table.services, port=0) as server:
        yield server


class Plain:
    """A client that stores frames unparsed."""

    def __init__(self, url: str) -> None:
        self.socket = connect(url, subprotocols=protocol.SUBPROTOCOLS, max_size=None)  # type: ignore[arg-type]

    def __enter__(self) -> "Plain":
        return self

    def __exit__(self, *_: object) -> None:
        self.socket.close()

    def next(self, *ops: str | int) -> Any:
        """Wait for a frame with one of these operations; integers stand for binary opcodes."""
        deadline_s = time.monotonic() + PATIENCE_S  # other frames keep arriving
        while True:
            frame = self.socket.recv(deadline_s - time.monotonic())
            found = json.loads(frame) if isinstance(frame, str) else frame
            if (found["op"] if isinstance(found, dict) else found[0]) in ops:
                return found

    def send(self, frame: str | bytes | dict[str, Any]) -> None:
        self.socket.send(json.dumps(frame) if isinstance(frame, dict) else frame)


def test_the_conversation_is_that_of_the_sdk() -> None:
    """The SDK's server and ours receive the same requests and send the same replies."""

    def fail(request: Any) -> bytes:
        raise ValueError("no")

    context, kind = foxglove.Context(), "std_srvs/srv/Trigger"
    schema = foxglove.Schema(name=TEXT, encoding="ros2msg", data=b"string data")
    text = foxglove.Channel("/t", message_encoding="cdr", schema=schema, context=context, metadata={"k": "v"})
    scene = SceneUpdateChannel("/s", context=context)
    request = MessageSchema(
        encoding="json", schema=foxglove.Schema(name=kind, encoding="jsonschema", data=b'{"type":"object"}')
    )
    values = [Parameter("rov.friction", value=0.5), Parameter("gain", value=[1.0, 2.0]), Parameter("on", value=True)]

    class Listener(foxglove.websocket.ServerListener):  # type: ignore[misc]
        def on_get_parameters(self, client: Any, names: list[str], request_id: str | None = None) -> Any:
            assert names == ["rov.friction", "gain", "on"]
            return values

    described = ServiceSchema(kind, request=request, response=request)
    peer = foxglove.start_server(
        name="uwsim", port=0, context=context, supported_encodings=["cdr", "json"],
        capabilities=[Capability.ClientPublish, Capability.Services, Capability.Time, Capability.Parameters],
        session_id="1", server_listener=Listener(),
        services=[
            foxglove.Service("/a", schema=described, handler=lambda request: b'{"success":true}'),
            foxglove.Service("/b", schema=described, handler=fail),
        ],
    )  # fmt: skip
    try:
        url, subprotocols = f"ws://127.0.0.1:{peer.port}", protocol.SUBPROTOCOLS
        with connect(f"{url}/?token=wrong", origin="https://any.example", subprotocols=subprotocols):  # type: ignore[arg-type]
            pass  # the reason why theirs is not ours
        theirs = Plain(url)
        info = theirs.next("serverInfo")
        info["metadata"].pop("fg-library")
        info.pop("metadata")
        ours = json.loads(protocol.server_info("uwsim", "1", has_parameters=True))
        assert set(ours["capabilities"]) - set(info["capabilities"]) <= {"parametersSubscribe"}
        assert info | {"capabilities": ours["capabilities"]} == ours
        update = SceneUpdate.get_schema()
        offers = [
            Offer(text.id(), "t", "cdr", TEXT, "ros2msg", b"string data", {"k": "v"}),
            Offer(scene.id(), "s", "protobuf", update.name, update.encoding, update.data),
        ]
        offered = {channel["id"]: channel for channel in theirs.next("advertise")["channels"]}
        ours = json.loads(protocol.advertisement(offers))["channels"]
        assert offered == {channel["id"]: channel for channel in ours}
        calls = theirs.next("advertiseServices")
        numbers = {service["name"].lstrip("/"): service["id"] for service in calls["services"]}
        both = [
            (numbers[service["name"].lstrip("/")], service["name"].lstrip("/"), kind) for service in calls["services"]
        ]
        assert calls == json.loads(protocol.services_advertisement(both))

        theirs.send({"op": "subscribe", "subscriptions": [{"id": 3, "channelId": text.id()}]})
        until(text.has_sinks)
        text.log(b"\0\1\0\0abc", log_time=5)
        assert theirs.next(protocol.MESSAGE) == protocol.message(3, 5, b"\0\1\0\0abc")
        peer.broadcast_time(7)
        assert theirs.next(protocol.TIME) == protocol.time(7)
        peer.publish_status("hm", foxglove.StatusLevel.Warning)
        assert theirs.next("status") == json.loads(protocol.status(protocol.WARNING, "hm"))
        theirs.send({"op": "getParameters", "parameterNames": ["rov.friction", "gain", "on"], "id": "r1"})
        plain = [described_parameter(*one) for one in (("rov.friction", 0.5), ("gain", [1.0, 2.0]), ("on", True))]
        assert theirs.next("parameterValues") == json.loads(protocol.parameter_values(plain, "r1"))
        for name in ("a", "b"):
            frame = struct.pack("<BIII", protocol.CALL, numbers[name], 9, 4) + b"json{}"
            call = protocol.read_binary(frame)
            assert call == Call(numbers[name], 9, "json", b"{}")
            theirs.send(frame)
            answer = theirs.next(protocol.ANSWER, "serviceCallFailure")
            if name == "a":
                assert answer == protocol.answer(call, {"success": True})
            else:
                assert answer == json.loads(protocol.call_failure(call, "ValueError: no"))
    finally:
        peer.stop()


def test_parameters_are_listed_set_and_reported(live: LiveSimulator, server: FoxgloveServer) -> None:
    client, other = Plain(server.url), Plain(server.url)
    assert {"parameters", "parametersSubscribe"} <= set(client.next("serverInfo")["capabilities"])

    def request(op: str, **fields: Any) -> dict[str, Any]:
        client.send({"op": op, "id": "r", **fields})
        answer = client.next("parameterValues")
        assert answer["id"] == "r"
        return {entry["name"]: entry.get("value") for entry in answer["parameters"]}

    own = live.simulator.parameters
    everything = request("getParameters", parameterNames=[])
    assert everything.keys() == set(own) and everything["rov.friction"] == own["rov.friction"] == 0.5
    surge = "rov.drag.linear.surge"
    before = own[surge]
    other.send({"op": "subscribeParameterUpdates", "parameterNames": [surge, "rov.friction"]})
    other.send({"op": "getParameters", "parameterNames": [surge], "id": "has subscribed"})
    assert other.next("parameterValues")["parameters"] == [{"name": surge, "value": before, "type": "float64"}]
    changes = [{"name": surge, "value": 60}, {"name": "optics.jerlov", "value": "5C"}]
    assert request("setParameters", parameters=changes) == {surge: 60.0, "optics.jerlov": "5C"}
    assert (own[surge], own["optics.jerlov"]) == (60.0, "5C")
    assert other.next("parameterValues") == {
        "op": "parameterValues", "parameters": [{"name": surge, "value": 60.0, "type": "float64"}]
    }  # fmt: skip
    live.command("set_parameter", name="rov.friction", value=0.7).result()
    assert [entry["value"] for entry in other.next("parameterValues")["parameters"]] == [0.7], "set by anything else"
    wrong = [{"name": "rov.friction", "value": 0.2}, {"name": surge, "value": -1.0}]
    client.send({"op": "setParameters", "id": "w", "parameters": wrong})
    assert surge in client.next("status")["message"]
    assert [entry["value"] for entry in client.next("parameterValues")["parameters"]] == [0.7, 60.0], "all or none"
    back = [{"name": name} for name in (surge, "optics.jerlov", "rov.friction")]
    assert request("setParameters", parameters=back)[surge] == before and own["rov.friction"] == 0.5
    client.send({"op": "getParameters", "parameterNames": ["rov.nothing"]})
    assert client.next("parameterValues") == {"op": "parameterValues", "parameters": []}
    assert "rov.nothing" in client.next("status")["message"]


def test_a_token_a_page_and_encryption(live: LiveSimulator, tmp_path: Path) -> None:
    certfile, keyfile = write_certificate(tmp_path)
    trusted, page = ssl.create_default_context(cafile=str(certfile)), "https://app.foxglove.dev"
    with FoxgloveServer(live, [], port=0, origins=[page], token=TOKEN, certfile=certfile, keyfile=keyfile) as server:
        assert server.url.startswith("wss://")
        url = f"wss://localhost:{server.port}/"
        options: dict[str, Any] = {"ssl": trusted, "subprotocols": protocol.SUBPROTOCOLS, "origin": page}
        assert json.loads(first_frame(f"{url}?token={TOKEN}", **options))["op"] == "serverInfo"
        for path in ("", "?token=another-horse"):
            with pytest.raises(InvalidStatus) as refused:
                first_frame(url + path, **options)
            assert refused.value.response.status_code == 401


def test_what_a_client_pressed_ends_with_it(live: LiveSimulator, server: FoxgloveServer) -> None:
    with FoxgloveClient(server.url) as client:
        client.call("/undock", {})
        client.publish("/key", "geometry_msgs/Pose", {"position": {"x": 1.0}})
        until(lambda: live.simulator.rov.effort[0] == 1.0)
    until(lambda: live.simulator.rov.effort[0] == 0.0)


HOSTILE: list[str | bytes | dict[str, Any]] = [
    "", "{", "[]", "null", "[" * 100_000, '{"op":' * 20_000, {"op": 7}, {"op": "subscribe"},
    {"op": "getParameters", "parameterNames": 7},
    {"op": "subscribe", "subscriptions": {}}, {"op": "subscribe", "subscriptions": [7]},
    {"op": "subscribe", "subscriptions": [{"id": -1, "channelId": 1}]},
    {"op": "subscribe", "subscriptions": [{"id": 1 << 40, "channelId": 1}]},
    {"op": "subscribe", "subscriptions": [{"id": True, "channelId": 1}]},
    {"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 1 << 70}]},
    {"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 0}] * 1001},
    {"op": "unsubscribe", "subscriptionIds": ["1"]}, {"op": "unadvertise", "channelIds": [3]},
    {"op": "advertise", "channels": [{"id": 1}]},
    {"op": "advertise", "channels": [{"id": 1, "topic": "/" * 300, "encoding": "json", "schemaName": "x"}]},
    b"", b"\1", b"\1\0\0\0\0", b"\2", b"\2" + b"\xff" * 12, b"\2" + b"\0" * 12 + b"\xff", b"\3\0\0", b"\xff" * 1000,
    struct.pack("<BIII", 2, 1, 1, 1 << 31) + b"json",
]  # fmt: skip


def test_a_hostile_frame_gets_an_answer_and_does_no_harm(server: FoxgloveServer) -> None:
    for frame in HOSTILE:
        with Plain(server.url) as client:
            client.next("advertise")
            client.send(frame)
            answer = client.next("status", "serviceCallFailure")
            assert 0 < len(answer["message"]) < 500 and "server failed" not in answer["message"], frame
            client.send({"op": "subscribe", "subscriptions": [{"id": 7, "channelId": 1}]})
            assert client.next(protocol.MESSAGE)[1:5] == struct.pack("<I", 7)


def test_a_message_is_bounded_before_it_is_read(server: FoxgloveServer) -> None:
    client = Plain(server.url)
    advertised = {"id": 1, "topic": "/cmd_vel", "encoding": "json", "schemaName": "geometry_msgs/Twist"}
    client.send({"op": "advertise", "channels": [advertised]})
    client.send(struct.pack("<BI", protocol.PUBLISH, 1) + b"[" * (session.MESSAGE_BYTES_MAX + 1))
    assert "16385 bytes: must be 16384 at most" in client.next("status")["message"]
    client.send(f'{{"op": "subscribe", "subscriptions": [{"[]," * 50_000}[]]}}')
    assert "characters: must be 131072 at most" in client.next("status")["message"]
    client.send(b"\1" * ((1 << 18) + 1))
    with pytest.raises(ConnectionClosed) as closed:
        client.next("nothing")
    assert closed.value.rcvd is not None and closed.value.rcvd.code == 1009  # message too big


def test_a_command_of_many_messages_is_refused_before_they_are_made(live: LiveSimulator) -> None:
    kind, heard = "std_msgs/msg/Float64MultiArray", list[object]()
    numbers = Channel("numbers", kind, "in", "numbers", apply=lambda live, message: heard.append(message))
    with FoxgloveServer(live, [numbers], port=0) as server:
        client = Plain(server.url)
        advertised = {"id": 1, "topic": "/numbers", "encoding": "json", "schemaName": kind}
        client.send({"op": "advertise", "channels": [advertised]})
        dimensions = b'{"layout":{"dim":[' + b",".join([b"{}"] * 5000) + b"]}}"
        client.send(struct.pack("<BI", protocol.PUBLISH, 1) + dimensions)
        assert "a message of more than 500 messages" in client.next("status")["message"] and not heard


def test_a_frame_of_mistakes_is_answered_in_brief() -> None:
    box, unknown = (
        Outbox(Room(), lambda: None, lambda reason: None),
        {"op": "unadvertise", "channelIds": list(range(1000))},
    )
    Session(SimpleNamespace(), box).receive(json.dumps(unknown))  # type: ignore[arg-type]
    shown = [json.loads(frame) for frame in iter(box.take, None)]
    assert len(shown) == session.MISTAKES_SHOWN and all("have not advertised" in one["message"] for one in shown)


def test_an_outbox_is_bounded_in_bytes_and_what_builds_up_is_never_lost_in_silence() -> None:
    reasons: list[str] = []
    room, data = Room(outbox.ALL_BYTES), bytes(1 << 20)
    boxes = [Outbox(room, lambda: None, reasons.append) for _ in range(40)]
    for box in boxes:
        for number in range(100):
            box.put((1, number, data))
        assert 0 < box.bytes <= outbox.MESSAGES_BYTES
        assert box.dropped > 0
    assert room.bytes == sum(box.bytes for box in boxes) <= room.most + 40 * (2 << 20)
    assert boxes[0].take() is not None and not reasons
    slow = boxes[0]
    for number in range(1000):
        slow.put((1, number, data), builds_up=True)
    assert len(reasons) == 1 and "reads too slowly" in reasons[0] and slow.bytes == 0
    for box in boxes:
        box.close()
    assert room.bytes == 0


def test_the_newest_messages_are_kept_in_their_order() -> None:
    box = Outbox(Room(), lambda: None, lambda reason: None)
    for number in range(100):
        box.put((1, number, b"x"))
        box.send_time(number)
    box.reply("first")
    frames = [box.take() for _ in range(outbox.MESSAGES + 3)]
    assert frames[:2] == ["first", protocol.time(99)] and frames[-1] is None
    assert frames[2:-1] == [protocol.message(1, number, b"x") for number in range(36, 100)]


def test_a_slow_reader_is_dropped_with_the_reason_and_delays_nobody(caplog: pytest.LogCaptureFixture) -> None:
    feed = PlayedFeed([Channel("t", TEXT, "out", "")])
    with FoxgloveServer(None, list(feed.channels.values()), port=0, feed=feed) as server:
        slow, other = Plain(server.url), Plain(server.url)
        for client in (slow, other):
            client.next("advertise")
            client.send({"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 1}]})
        until(lambda: len(server._offers._sinks.get("t", ())) == 2)
        data = b"\0\1\0\0" + struct.pack("<I", 1 << 20) + bytes(1 << 20)
        for number in range(60):
            feed.play(feed.channels["t"], SimpleNamespace(data=data, time_ns=number, topic="t"))  # type: ignore[arg-type]
            assert other.next(protocol.MESSAGE) == protocol.message(1, number, data)
        assert server._room.bytes <= 2 * outbox.MESSAGES_BYTES
        server._offers._shows["t"] = object()  # type: ignore[assignment]  # a topic that builds up, as scenes do
        sent = 0
        while len(server._listener.sessions) == 2 and sent < 300:
            server._offers.send("t", sent, data)
            assert other.next(protocol.MESSAGE) == protocol.message(1, sent, data)
            sent += 1
        until(lambda: len(server._listener.sessions) == 1)
        del server._offers._shows["t"]
        assert "is disconnected: it reads too slowly" in caplog.text
        assert server._room.bytes <= outbox.MESSAGES_BYTES
        with pytest.raises(ConnectionClosed):
            slow.next("nothing")


def test_a_client_makes_room_beyond_the_most_and_is_forgotten_when_it_leaves(
    live: LiveSimulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("uwsim.bridges.foxglove.server.CLIENTS_MAX", 4)
    with FoxgloveServer(live, Table(live.simulator).channels, port=0) as server:
        clients = [Plain(server.url) for _ in range(4)]
        for client in clients:
            client.next("serverInfo")
            client.send({"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 1}]})
        clients.append(Plain(server.url))
        clients[-1].next("serverInfo")
        until(lambda: sum(client.socket.close_code == CloseCode.TRY_AGAIN_LATER for client in clients) == 1)
        assert clients[-1].socket.close_code is None, "the newcomer"
        gone = [weakref.ref(one) for one in server._listener.sessions.values()]
        for client in clients:
            client.socket.close()
        until(lambda: not server._listener.sessions)
        gc.collect()
        until(lambda: not any(ref() for ref in gone))
        assert server._room.bytes == 0 and not server._ends


def test_calls_without_an_answer_are_bounded() -> None:
    """The service never answers; calls beyond the limit are refused immediately."""
    begun: list[Call] = []
    called = SimpleNamespace(answer=lambda call, reply: begun.append(call), is_vital=lambda call: False)
    box = Outbox(Room(), lambda: None, lambda reason: None)
    caller = Session(called, box)  # type: ignore[arg-type]
    for number in range(session.CALLS_MAX + 5):
        caller.receive(struct.pack("<BIII", protocol.CALL, 1, number, 4) + b"json{}")
    assert len(begun) == session.CALLS_MAX
    failures = [json.loads(box.take() or "") for _ in range(5)]
    assert all("are still unanswered" in failure["message"] for failure in failures) and box.take() is None


def test_an_error_of_a_service_goes_to_its_caller(live: LiveSimulator) -> None:
    def refuse(live: LiveSimulator, request: dict[str, Any]) -> dict[str, Any]:
        raise ValueError("depth = 9 m: must be in [0, 4]")

    with FoxgloveServer(live, [], [Service("dive", "std_srvs/srv/Trigger", refuse)], port=0) as server:
        client = Plain(server.url)
        client.send(struct.pack("<BIII", protocol.CALL, 1, 5, 4) + b"json{}")
        expected = {
            "op": "serviceCallFailure",
            "serviceId": 1,
            "callId": 5,
            "message": "depth = 9 m: must be in [0, 4]",
        }
        assert client.next("serviceCallFailure") == expected
