"""The cost of a client's frames to a rosbridge: memory and the network thread's time, for one attack at a time.

    .venv/bin/python tools/soak/amplification.py [NAME ...]

Each attack comes from a separate process against a new server. One line per attack reports: the attack's frames; the
peak growth of resident memory, and the growth that remained after all clients had left; the longest time for which the
network thread missed a 2 ms timer (by the wall clock, which includes time that other processes used); the largest CPU
time, between two timers, of all threads of the process and of the network thread; and the slowest answer to another
client, which calls a service continuously.
"""

from __future__ import annotations

import asyncio
import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from pathlib import Path
from threading import Event, Thread

import cbor2
import numpy as np
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from uwsim.bridges import RosbridgeServer
from uwsim.cli.run_live import keep_threads_moving

SIZE = 2 << 20  # maximum size of a frame
BEAT_S = 0.002
PATIENCE_S = 60.0
Frames = Iterator[str | bytes]


def publishes(kind: str, field: str, element: str, size: int = SIZE - 200) -> Frames:
    """Publish a list with as many elements as fit in a frame."""
    yield json.dumps({"op": "advertise", "topic": "/t", "type": kind})
    yield f'{{"op":"publish","topic":"/t","msg":{{"{field}":[{",".join([element] * (size // (len(element) + 1)))}]}}}}'


def typed(kind: str, field: str, array: bytes, tag: int) -> Frames:
    """Publish a typed array in CBOR."""
    yield json.dumps({"op": "advertise", "topic": "/t", "type": kind})
    yield cbor2.dumps({"op": "publish", "topic": "/t", "msg": {field: cbor2.CBORTag(tag, array)}})


def image() -> Frames:
    """Publish an image in base64."""
    yield json.dumps({"op": "advertise", "topic": "/t", "type": "sensor_msgs/CompressedImage"})
    yield json.dumps({"op": "publish", "topic": "/t", "msg": {"data": "AAAA" * ((SIZE - 200) // 4)}})


def poses() -> Frames:
    """Publish a path of 3,000 complete poses."""
    pose = {"position": {"x": 1.25, "y": 2.5, "z": 3.75}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}
    header = {"stamp": {"secs": 1, "nsecs": 2}, "frame_id": "odom"}
    element = json.dumps({"header": header, "pose": pose})
    return publishes("nav_msgs/Path", "poses", element, 3000 * (len(element) + 1))


def whole_calls() -> Frames:
    """Call a service with many empty lists."""
    yield json.dumps({"op": "call_service", "service": "/rosapi/topics", "args": {"a": "?"}}).replace(
        '"?"', f"[{','.join(['[]'] * 690_000)}]"
    )


def fragments() -> Frames:
    """Publish many empty markers in ten pieces."""
    whole = list(publishes("visualization_msgs/MarkerArray", "markers", "{}", SIZE - 1000))
    yield whole[0]
    step = len(whole[1]) // 10 + 1
    for k in range(10):
        data = whole[1][k * step : (k + 1) * step]
        yield json.dumps({"op": "fragment", "id": "f", "num": k, "total": 10, "data": data})


ONCE: dict[str, Callable[[], Frames]] = {
    "nothing": lambda: iter(()),
    "empty markers, 2 MB": lambda: publishes("visualization_msgs/MarkerArray", "markers", "{}"),
    "empty markers, 50 kB": lambda: publishes("visualization_msgs/MarkerArray", "markers", "{}", 50_000),
    "empty poses, 2 MB": lambda: publishes("nav_msgs/Path", "poses", "{}"),
    "empty diagnostics, 2 MB": lambda: publishes("diagnostic_msgs/DiagnosticArray", "status", "{}"),
    "empty names, 2 MB": lambda: publishes("sensor_msgs/JointState", "name", '""'),
    "empty markers in fragments": fragments,
    "empty lists as arguments": whole_calls,
    "CBOR of empty lists, 2 MB": lambda: iter([cbor2.dumps({"a": [[]] * 2_000_000})]),
    "CBOR of empty lists, 50 kB": lambda: iter([cbor2.dumps({"a": [[]] * 50_000})]),
    "a path of 3000 poses": poses,
    "a picture in base64, 2 MB": image,
    "bytes as a list, 2 MB": lambda: publishes("std_msgs/UInt8MultiArray", "data", "255"),
    "numbers as a list, 2 MB": lambda: publishes("std_msgs/Float64MultiArray", "data", "1.5"),
    "a typed array, 2 MB": lambda: typed(
        "sensor_msgs/LaserScan", "ranges", np.linspace(1.0, 2.0, 500_000, dtype="<f4").tobytes(), 85
    ),
    "a typed array of bytes as float64, 2 MB": lambda: typed(
        "std_msgs/Float64MultiArray", "data", b"\x07" * 2_000_000, 64
    ),
}


def flood(url: str, count: int, frame: Callable[[int], str], first: tuple[str, ...] = ()) -> None:
    """Send the frames of `first`, and then frame(0) to frame(count - 1)."""
    with (
        suppress(ConnectionClosed),
        connect(url, compression=None, max_size=None, ping_interval=None, close_timeout=0.1) as client,
    ):
        for operation in first:
            client.send(operation)
        for k in range(count):
            client.send(frame(k))
        settle(client)


def settle(client: ClientConnection) -> None:
    """Return when the server has processed everything that was sent."""
    client.send('{"op":"call_service","service":"/rosapi/get_time","id":"last"}')
    while json.loads(client.recv(PATIENCE_S)).get("id") != "last":
        pass


def slow_reader(url: str) -> None:
    """Subscribe to 20 topics, each of which carries ten messages of 2 MB, and do not read."""
    with connect(url, compression=None, max_size=None, max_queue=1, ping_interval=None, close_timeout=0.1) as reader:
        for k in range(20):
            reader.send(json.dumps({"op": "subscribe", "topic": f"/t{k}", "type": "std_msgs/String"}))
        data = "x" * (SIZE - 200)
        publish = lambda k: f'{{"op":"publish","topic":"/t{k % 20}","msg":{{"data":"{data}"}}}}'  # noqa: E731
        first = tuple(json.dumps({"op": "advertise", "topic": f"/t{k}", "type": "std_msgs/String"}) for k in range(20))
        flood(url, 200, publish, first)
        time.sleep(2.0)


def latched(url: str) -> None:
    """Latch 2 MB on each of 100 topics."""
    data = "x" * (SIZE - 200)
    names = range(100)
    first = tuple(
        json.dumps({"op": "advertise", "topic": f"/t{k}", "type": "std_msgs/String", "latch": True}) for k in names
    )
    flood(url, 100, lambda k: f'{{"op":"publish","topic":"/t{k}","msg":{{"data":"{data}"}}}}', first)


def unanswered(url: str) -> None:
    """Call a service that never answers, 100 times with 2 MB."""
    with connect(url, compression=None, max_size=None, max_queue=1, ping_interval=None, close_timeout=0.1) as server:
        server.send('{"op":"advertise_service","service":"/never","type":"demo/Never"}')
        time.sleep(0.5)
        data = "x" * (SIZE - 200)
        flood(url, 100, lambda k: f'{{"op":"call_service","service":"/never","id":"{k}","args":{{"a":"{data}"}}}}')


def long_ids(url: str) -> None:
    """Subscribe to a topic using 2 MB ids."""
    pad = "x" * (SIZE - 200)
    flood(url, 100, lambda k: f'{{"op":"subscribe","topic":"/t","type":"std_msgs/String","id":"{k}{pad}"}}')


def rosapi_texts(url: str) -> None:
    """Advertise 900 topics whose type has a long definition, and request all definitions five times."""
    kind = "visualization_msgs/MarkerArray"
    first = tuple(json.dumps({"op": "advertise", "topic": f"/t{k}", "type": kind}) for k in range(900))
    flood(url, 5, lambda k: '{"op":"call_service","service":"/rosapi/topics_and_raw_types"}', first)


def transforms(url: str) -> None:
    """Publish 2,000 transforms at once while another client looks up transforms."""
    call = '{"op":"call_service","service":"/republish_tfs","args":{"source_frames":["a"],"target_frame":"b"}}'
    head = '{"op":"advertise","topic":"/tf","type":"tf2_msgs/TFMessage"}'
    turned = '"transform":{"translation":{"x":1.5},"rotation":{"w":1.0}}'
    all_of_them = ",".join(f'{{"header":{{"frame_id":"base"}},"child_frame_id":"{k}",{turned}}}' for k in range(2000))
    flood(url, 3, lambda k: f'{{"op":"publish","topic":"/tf","msg":{{"transforms":[{all_of_them}]}}}}', (call, head))


LONG: dict[str, Callable[[str], None]] = {
    "a reader of 20 topics of 2 MB that does not read": slow_reader,
    "2 MB latched on 100 topics": latched,
    "100 unanswered calls of 2 MB": unanswered,
    "100 ids of 2 MB": long_ids,
    "all definitions of 900 topics": rosapi_texts,
    "2,000 transforms at once": transforms,
}


def once(url: str, name: str) -> None:
    """Send one attack's frames while another client subscribes with each compression."""
    options = {"compression": None, "max_size": None, "ping_interval": None, "close_timeout": 0.1}
    with ExitStack() as stack:
        for compression in ("none", "cbor", "png"):
            reader = stack.enter_context(connect(url, **options))
            reader.send(json.dumps({"op": "subscribe", "topic": "/t", "compression": compression}))
            Thread(target=list, args=(reader,), daemon=True).start()
        client = stack.enter_context(connect(url, **options))
        for frame in ONCE[name]():
            client.send(frame)
        client.send('{"op":"call_service","service":"/rosapi/get_time","id":"last"}')
        while True:
            answer = json.loads(client.recv(PATIENCE_S))
            if answer.get("id") == "last":
                break
            if answer["op"] == "status":
                print(f"    refused: {answer['msg'][:150]}")
        time.sleep(1.0)


def memory_mb(field: str) -> float:
    """Return this process's resident memory in MB: VmRSS for the current size, VmHWM for the peak."""
    text = Path("/proc/self/status").read_text()
    return next(int(line.split()[1]) for line in text.splitlines() if line.startswith(field)) / 1e3


class Watch:
    """The longest delays of a timer on the network thread, and of the answers to another client."""

    def __init__(self, server: RosbridgeServer) -> None:
        self.held_s = self.spent_s = self.worked_s = self.answer_s = 0.0
        self._server = server
        self._ends = Event()
        self._witness = Thread(target=self._ask)

    def __enter__(self) -> Watch:
        self._beat = asyncio.run_coroutine_threadsafe(self._count(), self._server._listener.loop)
        self._witness.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ends.set()
        self._witness.join()
        self._beat.cancel()

    async def _count(self) -> None:
        while True:
            begun_s, spent_s, worked_s = time.monotonic(), time.process_time(), time.thread_time()
            await asyncio.sleep(BEAT_S)
            self.spent_s = max(self.spent_s, time.process_time() - spent_s)
            self.held_s = max(self.held_s, time.monotonic() - begun_s - BEAT_S)
            self.worked_s = max(self.worked_s, time.thread_time() - worked_s)

    def _ask(self) -> None:
        process = subprocess.Popen(
            [sys.executable, __file__, "--witness", self._server.url], stdout=subprocess.PIPE, stdin=subprocess.PIPE
        )
        self._ends.wait()
        self.answer_s = float(process.communicate(b"\n")[0])


def witness(url: str) -> float:
    """Call for the time repeatedly until standard input closes; return the longest wait for an answer."""
    worst_s, ends = 0.0, Event()
    Thread(target=lambda: (sys.stdin.readline(), ends.set()), daemon=True).start()
    with connect(url, compression=None, ping_interval=None) as client:
        settle(client)
        while not ends.is_set():
            begun_s = time.monotonic()
            try:
                settle(client)
            except (TimeoutError, ConnectionClosed):
                return PATIENCE_S
            worst_s = max(worst_s, time.monotonic() - begun_s)
            time.sleep(0.01)
    return worst_s


def main(names: list[str]) -> None:
    """Run the attacks with these names; by default, all."""
    for name in names or [*ONCE, *LONG]:
        subprocess.run([sys.executable, __file__, "--serve", name], check=True)


def serve(name: str) -> None:
    """Run the server for one attack."""
    with RosbridgeServer(None) as server:
        with connect(server.url) as client:
            settle(client)
        keep_threads_moving()
        first_mb = memory_mb("VmRSS")
        Path("/proc/self/clear_refs").write_text("5")  # resets the recorded peak
        with Watch(server) as watch:
            time.sleep(1.0)
            watch.held_s = watch.spent_s = watch.worked_s = 0.0
            attack = subprocess.run([sys.executable, __file__, "--attack", server.url, name], timeout=600)
            time.sleep(1.0)
        time.sleep(1.0)
        most_mb, last_mb = memory_mb("VmHWM"), memory_mb("VmRSS")
        print(
            f"{name}: {first_mb:.0f} MB, at most +{most_mb - first_mb:.0f}, at the end +{last_mb - first_mb:.0f}; "
            f"held for {1e3 * watch.held_s:.0f} ms, "
            f"meanwhile {1e3 * watch.spent_s:.0f} ms of all threads' time, "
            f"{1e3 * watch.worked_s:.0f} ms of its own; worst answer {1e3 * watch.answer_s:.0f} ms; "
            f"{len(server.sessions)} sessions left" + ("" if attack.returncode == 0 else "; the attack failed"),
            flush=True,
        )


if __name__ == "__main__":
    if sys.argv[1:2] == ["--attack"]:
        url, name = sys.argv[2:]
        try:
            once(url, name) if name in ONCE else LONG[name](url)
        except TimeoutError:
            print(f"    no answer within {PATIENCE_S:g} s")
    elif sys.argv[1:2] == ["--witness"]:
        print(witness(sys.argv[2]))
    elif sys.argv[1:2] == ["--serve"]:
        serve(sys.argv[2])
    else:
        main(sys.argv[1:])
