"""Memory cost of a client's frames: at most Limits.cost_of(size) if accepted, less if refused.

Memory is traced and work is counted in slices, so the tests do not depend on the machine's speed.
"""

import gc
import json
import tracemalloc
from types import SimpleNamespace

import cbor2
import numpy as np
import orjson
import pytest
from hypothesis import given
from hypothesis import strategies as st
from websockets.sync.client import connect

from uwsim.bridges import RosbridgeServer
from uwsim.bridges.doors.conversation import PIECE
from uwsim.bridges.rosbridge.encoding import to_json
from uwsim.bridges.rosbridge.graph import Graph
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.bridges.rosbridge.parse import read
from uwsim.bridges.rosbridge.session import Session
from uwsim.bridges.rosbridge.weigh import ITEMS_PER_OBJECT, exact_load, walk_cbor
from uwsim.channels.ros.message_cost import SLICE_NUMBERS, SLICE_OBJECTS, Meter, cost_of, held_bytes
from uwsim.channels.ros.message_out import NUMBERS
from uwsim.channels.ros.message_types import fields
from uwsim.channels.ros.messages import default_message, from_plain, to_plain, typestore

SIZE = 15_000
LIMITS = Limits(cost_bytes=20 * SIZE)  # small, so that many types can be tested
TYPES = sorted(typestore().fielddefs)


class Traced:
    """Measure peak memory over several phases, and the memory still held at the end.

    orjson reserves a tree of twelve times the text's size but uses only 16 bytes per value.
    """

    def __init__(self, frame):
        self.most = self.held = 0
        self._pauses = 0
        self._tree = 12 * len(frame) if isinstance(frame, str) else 0
        self._used = 16 * (frame.count(",") + frame.count(":") + 1) if isinstance(frame, str) else 0

    def __enter__(self):
        gc.disable()
        tracemalloc.start()
        return self

    def __exit__(self, *_):
        self._look()
        self.held = tracemalloc.get_traced_memory()[0]
        tracemalloc.stop()
        gc.enable()

    def _look(self):
        self.most = max(self.most, tracemalloc.get_traced_memory()[1])
        tracemalloc.reset_peak()

    def pause(self):
        """Record the peak between slices. The second pause follows decoding, whose peak may include orjson's tree."""
        self._pauses += 1
        if self._pauses == 2:
            now, peak = tracemalloc.get_traced_memory()
            self.most = max(self.most, peak - self._tree + self._used if peak - now > 0.9 * self._tree else peak)
            tracemalloc.reset_peak()
        else:
            self._look()


def lists_of(name, depth=3):
    """Yield, for each list in a message, the path of keys that leads to it and the kind of its elements."""
    for field in fields(name, 2):
        if field.kind.length == 0:
            yield [field.name], field.kind
        if field.kind.is_message and field.kind.length in (None, 0) and depth:
            way = [field.name] if field.kind.length is None else [field.name, 0]
            for inner, kind in lists_of(field.kind.base, depth - 1):
                yield way + inner, kind


def elements(kind):
    """Yield elements as JSON: those that expand a few bytes into the most memory, and complete ones."""
    if kind.is_message:
        yield "{}"
        yield "null"
        yield orjson.dumps(to_plain(default_message(kind.base)), option=orjson.OPT_SERIALIZE_NUMPY).decode()
    elif kind.base == "bool":
        yield "true"
    elif kind.base in NUMBERS:
        yield from ("0", "1.0", "100")
    else:
        yield from ('""', '"ab"', '"\\u0001"')


def nested(way, text):
    for step in reversed(way):
        text = f"[{text}]" if step == 0 else f'{{"{step}":{text}}}'
    return text


def shapes():
    """Yield, once for each kind of list: a type, a frame with one element, and a frame with many."""
    seen = set()
    for name in TYPES:
        for way, kind in lists_of(name):
            if kind not in seen:
                seen.add(kind)
                for element in elements(kind):
                    one, many = (
                        f'{{"op":"publish","topic":"t","msg":{nested(way, f"[{part}]")}}}'
                        for part in (element, ",".join([element] * (SIZE // (len(element) + 1))))
                    )
                    yield name, one, many


def publisher(name, limits=LIMITS):
    graph = Graph()
    session = Session(graph, "/one", limits=limits)
    session.receive(json.dumps({"op": "advertise", "topic": "t", "type": name}))
    return session


def cost(session, frame, written=((1, "json"), (1, "cbor"), (2, "json"), (2, "cbor"))):
    """Return the peak memory used to read a frame and write its message, and the error, if any."""
    with Traced(frame) as traced:
        prepared = session.prepare(frame, traced.pause)
    made = prepared.operation.get("msg")
    if prepared.error is not None:
        return traced.most, prepared.error
    held = traced.held
    for ros, form in written:
        with Traced("") as writing:
            plain = to_plain(made.message, ros, form)
        text = cbor2.dumps(plain) if form == "cbor" else to_json(plain)
        traced.most = max(traced.most, held + writing.most + 2 * len(text))
    return traced.most, None


def test_no_frame_of_any_type_takes_more_memory_than_its_size_allows():
    """Test every kind of list of every type, filled with the cheapest elements to send and with complete ones."""
    accepted = 0
    cost(publisher("nav_msgs/msg/Path"), f'{{"a":[{",".join(["{}"] * 5000)}]}}')  # triggers lazy imports
    for name, one, frame in shapes():
        session = publisher(name)
        cost(session, one)  # fills the per-type caches
        most, error = cost(session, frame)
        times = f"{most / len(frame):.1f} times, {error}"
        assert most <= LIMITS.cost_of(len(frame)), f"{name} {frame[:120]}: {times}"
        accepted += error is None
    assert accepted > 50


def test_a_message_costs_no_more_than_is_said_before_it_is_made():
    """For every type: the charge for a message without lists bounds the memory per message, averaged over a hundred."""
    for name in TYPES:
        for _ in range(50):
            default_message(name)  # the first instances of a class have separate dicts
        with Traced("") as traced:
            made = [default_message(name) for _ in range(100)]
        assert traced.held <= 100 * cost_of(name).made_bytes + 4000, name
        assert held_bytes(made[0]) >= cost_of(name).made_bytes


def test_work_is_done_in_slices():
    """No more than one slice of objects or numbers is produced between two pauses."""
    path = {"poses": [{}] * 3000}
    numbers = {"ranges": [1.5] * 100_000}
    for name, plain, slices in (
        ("nav_msgs/msg/Path", path, 3000 * cost_of("geometry_msgs/msg/PoseStamped").objects / SLICE_OBJECTS),
        ("sensor_msgs/msg/LaserScan", numbers, 100_000 / SLICE_NUMBERS),
        ("visualization_msgs/msg/MarkerArray", {"markers": [{"points": [{}] * 200}] * 20}, 0),
    ):
        pauses, meter = [], None
        meter = Meter(pause=lambda pauses=pauses: pauses.append(1))
        from_plain(name, plain, meter=meter)
        assert len(pauses) == meter.pauses >= int(slices)


def cbor_array(item, count):
    """Return {"a": [item, ...]}, for which cbor2 itself would take seconds."""
    return b"\xa1\x61a\x9a" + count.to_bytes(4) + item * count


MUCH_OF_LITTLE = {
    "lists": lambda: cbor_array(b"\x80", 1_900_000),
    "numbers": lambda: cbor_array(b"\x00", 1_900_000),
    "lists in lists": lambda: b"\xa1\x61a\x99\xff\xff" + b"\x81" * 30 + b"\x80" * 1_000_000,
    "tags": lambda: cbor_array(b"\xd8\x40\x40", 600_000),
    "lists as text": lambda: '{"a":[' + ",".join(["[]"] * 690_000) + "]}",
    "empty texts": lambda: '{"a":[' + ",".join(['""'] * 690_000) + "]}",
    "objects": lambda: '{"a":[' + ",".join(['{"x":1}'] * 15_000) + "]}",
    "a call": lambda: '{"op":"call_service","service":"/never","args":[' + ",".join(["{}"] * 19_000) + "]}",
    "a response": lambda: '{"op":"service_response","id":"1","values":[' + ",".join(["{}"] * 19_000) + "]}",
}


@pytest.mark.parametrize("what", MUCH_OF_LITTLE)
def test_what_would_make_much_of_little_is_refused_before_it_is_decoded(what, monkeypatch):
    frame = MUCH_OF_LITTLE[what]()
    session = publisher("std_msgs/msg/String")
    monkeypatch.setattr("uwsim.bridges.rosbridge.parse._decode", lambda *_, **__: pytest.fail("decoded"))
    with Traced("") as traced:
        error = session.prepare(frame).error
    assert error.startswith("frame: ") and ("at most" in error or "of more than" in error)
    assert traced.most <= 20 * len(frame)


def test_a_walk_over_cbor_ends_where_it_holds_too_much():
    """Refusing a frame of two million empty lists used to take 2.7 s; at most 20,000 of those here are visited."""

    class Counted(bytes):
        looks = 0

        def __getitem__(self, index):
            Counted.looks += 1
            return super().__getitem__(index)

    for data in (cbor2.dumps([[]] * 200_000), b"\x81" * 3 + cbor2.dumps([[[]] * 10] * 20_000)):
        Counted.looks = 0
        with pytest.raises(ValueError, match="more than"):
            walk_cbor(Counted(data), 32, Limits().objects)
        assert Counted.looks < 3 * ITEMS_PER_OBJECT * Limits().objects


def whole(name, message):
    return f'{{"op":"publish","topic":"t","msg":{json.dumps(message, separators=(",", ":"), ensure_ascii=False)}}}'


POSE = {
    "header": {"stamp": {"secs": 1, "nsecs": 2}, "frame_id": "odom"},
    "pose": {
        "position": {"x": 1.25, "y": 2.5, "z": 3.75},
        "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
    },
}
POINTS = np.linspace(1.0, 2.0, 500_000, dtype="<f4").tobytes()


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("sensor_msgs/msg/Image", {"data": "AAAA" * 500_000}),
        ("sensor_msgs/msg/Image", {"data": b"\0" * 2_000_000}),
        ("sensor_msgs/msg/Image", {"data": [200] * 500_000}),
        ("sensor_msgs/msg/Image", {"data": [0] * 900_000}),
        ("sensor_msgs/msg/PointCloud2", {"data": "AAAA" * 500_000}),
        ("sensor_msgs/msg/LaserScan", {"ranges": cbor2.CBORTag(85, POINTS)}),
        ("sensor_msgs/msg/LaserScan", {"ranges": [1.25] * 200_000}),
        ("nav_msgs/msg/OccupancyGrid", {"data": [-1] * 300_000}),
        ("nav_msgs/msg/Path", {"poses": [POSE] * 1500}),
        ("nav_msgs/msg/Path", {"poses": [POSE] * 400}),
        ("std_msgs/msg/String", {"data": "é" * 900_000}),
        ("std_msgs/msg/String", {"data": "1e5.," * 300_000}),
    ],
)
def test_large_messages_that_are_what_they_seem_are_taken(name, message):
    as_bytes = isinstance(next(iter(message.values())), bytes | cbor2.CBORTag)
    frame = cbor2.dumps({"op": "publish", "topic": "t", "msg": message}) if as_bytes else whole(name, message)
    most, error = cost(publisher(name, Limits()), frame, ((1, "json"), (2, "cbor")))
    assert error is None and most <= 20 * len(frame)


@pytest.mark.parametrize(
    ("values", "accepted"),
    [
        ([1.5] * 500_000, True),
        ([None, -3, True] * 200_000, True),
        ([[1.5] * 100] * 5000, True),
        ([[1.5] * 25] * 15_000, False),
        ([{"x": [0.25] * 400_000, "y": ["[1,2", 2.5, "]"]}] * 1, True),
        ([True] * 13_000 + ["x"] + [1.5] * 300_000, False),
    ],
)
def test_no_decoder_gets_more_than_150000_values_in_one_call(values, accepted, monkeypatch):
    """A decoder's call blocks all other threads: one with 500,000 fractions did so for 28 ms."""
    text, calls = json.dumps({"op": "publish", "a": values}, separators=(",", ":")), []

    def counting(loads):
        return lambda part: (
            calls.append(part.count(b"," if isinstance(part, bytes | bytearray) else ",")) or loads(part)
        )

    decoders = SimpleNamespace(loads=counting(orjson.loads), JSONDecodeError=orjson.JSONDecodeError)
    monkeypatch.setattr("uwsim.bridges.rosbridge.parse.orjson", decoders)
    kept = {"JSONDecodeError": json.JSONDecodeError}
    monkeypatch.setattr("uwsim.base.texts.json_text.json", SimpleNamespace(loads=counting(json.loads), **kept))
    if accepted:
        assert read(text, Limits())[0]["a"] == values
    else:
        with pytest.raises(ValueError, match="at most"):
            read(text, Limits())
    assert max(calls, default=0) <= 150_000


@pytest.mark.parametrize("end", [",]", ",,1]", "}", "", ",nan]"])
def test_a_long_list_that_is_not_json_is_refused(end):
    for start in ("[", "[,"):
        with pytest.raises(ValueError, match="not JSON"):
            read('{"a":' + start + ",".join(["1.5"] * 100_000) + end + "}", Limits())


def test_fragments_are_held_to_the_same():
    session = publisher("nav_msgs/msg/Path")
    frame = f'{{"op":"publish","topic":"t","msg":{{"poses":[{",".join(["{}"] * 5000)}]}}}}'
    for k in range(4):
        part = frame[k * len(frame) // 4 : (k + 1) * len(frame) // 4]
        session.receive(json.dumps({"op": "fragment", "id": "f", "num": k, "total": 4, "data": part}))
    status = json.loads(session.outbox.take()[0])
    assert status["op"] == "status" and "memory at most" in status["msg"]


TEXTS = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text('a"\\,:{}[] é', max_size=8),
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(st.text('a"\\,:{}[]', max_size=4), inner, max_size=5),
    max_leaves=30,
)


def counted(value):
    """Count objects and lists, string values, members, and distinct keys."""
    if isinstance(value, str):
        return 0, 1, 0, set()
    parts = list(value.values()) if isinstance(value, dict) else value if isinstance(value, list) else []
    inner = [counted(part) for part in parts]
    own = isinstance(value, dict | list), 0, len(value) if isinstance(value, dict) else 0
    keys = set(value) if isinstance(value, dict) else set()
    return *(own[k] + sum(i[k] for i in inner) for k in range(3)), keys.union(*(i[3] for i in inner))


@given(TEXTS, st.booleans())
def test_a_text_is_weighed_by_what_it_holds(value, spaced):
    text = json.dumps(value, ensure_ascii=False, separators=None if spaced else (",", ":"))
    load = exact_load(text)
    containers, strings, members, keys = counted(value)
    assert (load.containers, load.strings, load.members) == (containers, strings, members)
    assert load.keys <= len(keys)
    if all(len(key) <= 8 for key in keys):
        assert load.keys >= len({key for key in keys if "\\" not in json.dumps(key)})


@pytest.mark.parametrize("data", ["x" * 1_500_000, b"\x07" * 1_500_000])
def test_a_large_message_is_sent_in_several_frames_so_that_no_write_is_long(data):
    kind = "std_msgs/String" if isinstance(data, str) else "std_msgs/UInt8MultiArray"
    with RosbridgeServer(None) as server, connect(server.url, max_size=None) as reader, connect(server.url) as writer:
        reader.send(json.dumps({"op": "subscribe", "topic": "t", "type": kind, "compression": "cbor"}))
        writer.send(json.dumps({"op": "advertise", "topic": "t", "type": kind}))
        writer.send(cbor2.dumps({"op": "publish", "topic": "t", "msg": {"data": data}}))
        parts = list(reader.recv_streaming())
    assert max(map(len, parts)) <= PIECE
    assert cbor2.loads(b"".join(parts))["msg"]["data"] == data
