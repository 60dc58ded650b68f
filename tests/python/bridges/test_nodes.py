"""The paper's processing chain as processes over rosbridge: its map is byte-identical to the single-process map."""

import json
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from websockets.sync.server import serve

from uwsim.bridges import RosbridgeServer
from uwsim.bridges.cli.nodes import nodes
from uwsim.bridges.nodes.chain import INSERTED, PUBLISHED_FLOATS, SCAN, decode, to_cloud, to_scan, to_transform
from uwsim.bridges.nodes.map_builder import MapBuilder
from uwsim.bridges.nodes.node import Node
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.channels import channels
from uwsim.channels.ros.messages import default_message
from uwsim.live import LiveSimulator
from uwsim.mapping import OccupancyMap
from uwsim.simulator.simulator import Simulator

PATIENCE_S = 60.0
UWSIM = Path(sys.executable).with_name("uwsim")
PINGS = 60  # a short survey: two lanes, each with a turn
LANE = 30


def until(condition, process):
    deadline = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < deadline
        assert process.poll() is None
        time.sleep(0.01)


def interval_steps(sim):
    rate_hz = next(channel.rate_hz for channel in channels(sim, wire="published") if channel.name == "depthArray")
    return round(1.0 / rate_hz / sim.step_s)


def effort(ping):
    """Return the efforts at a ping of the flight: lanes ahead, descending at first, each followed by a half turn."""
    turning = ping % LANE >= LANE - 14
    return {"surge": 0.2 if turning else 1.0, "yaw": 1.0 if turning else 0.0, "heave": -0.5 if ping < LANE else 0.0}


def chain_in_process(path):
    """Fly the same path in this process, passing the channels' messages through the nodes' functions."""
    sim, builder = Simulator("lake"), MapBuilder()
    table = {channel.name: channel for channel in channels(sim, wire="published")}
    flown = []
    for ping in range(PINGS):
        flown.append(sim.rov.pose.position_world_m)
        if ping == 1:
            sim.rov.undock()
        sim.rov.set_effort(**effort(ping))
        sim.step(0 if ping == 0 else interval_steps(sim))
        stamp = default_message("builtin_interfaces/msg/Time")
        stamp.sec, stamp.nanosec = divmod(sim.time_ns, 10**9)
        model = sim.rov.sonar.model.number
        for topic, parent, child in (("propPos", "odom", "base_footprint"), ("scanPos", "base_footprint", "base_scan")):
            builder.add_transforms(to_transform(table[topic].read(sim), stamp, parent, child))
        builder.add_cloud(to_cloud(to_scan(decode(table["depthArray"].read(sim), model), model, stamp), model))
        builder.insert_ready()
    assert builder.inserted == PINGS
    builder.write(path)
    return np.array(flown)


def test_five_processes_make_the_map_of_one(tmp_path):
    heard, limits = [], Limits(work_share=1.0)
    with LiveSimulator("lake", paused=True) as live, RosbridgeServer(live, wire="published", limits=limits) as server:
        arguments = [UWSIM, "nodes", "--url", server.url, "--out", tmp_path / "nodes.bt"]
        process = subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True)
        try:
            until(lambda: INSERTED in server.graph.topics, process)
            server._listener.loop.call_soon_threadsafe(
                lambda: server.graph.subscribe("/test", 0, INSERTED, None, lambda s: heard.append(s.message.data))
            )
            assert "octomap" in process.stdout.readline()
            for ping in range(PINGS):
                if ping == 1:
                    live.rov.undock()
                live.rov.set_effort(**effort(ping))
                live.step(0 if ping == 0 else interval_steps(live.simulator))
                until(lambda ping=ping: heard[-1:] == [ping + 1], process)
            process.send_signal(signal.SIGINT)
            assert process.wait(PATIENCE_S) == 0
        finally:
            process.kill()
            process.wait()
    flown = chain_in_process(tmp_path / "chain.bt")
    assert np.ptp(flown, axis=0)[:2].min() > 3.0
    assert (tmp_path / "nodes.bt").read_bytes() == (tmp_path / "chain.bt").read_bytes()
    assert len((tmp_path / "chain.bt").read_bytes()) > 20_000


def test_the_map_is_octomaps_own():
    assert MapBuilder().map.engine == "octomap"


def test_clouds_wait_for_the_transforms_of_their_time():
    builder = MapBuilder()
    stamp = default_message("builtin_interfaces/msg/Time")
    stamp.sec = 5
    scan = to_scan(type("Decoded", (), {"data": np.full(513, 10.0, np.float32)}), 2, stamp)
    builder.add_cloud(to_cloud(scan, 2))
    pose = default_message("geometry_msgs/msg/Pose")
    pose.orientation.w = 1.0
    for parent, child, expected in (("odom", "base_footprint", 0), ("base_footprint", "base_scan", 1)):
        builder.add_transforms(to_transform(pose, stamp, parent, child))
        assert builder.insert_ready() == expected


def test_a_missing_server_is_named():
    with pytest.raises(OSError, match=r"ws://127\.0\.0\.1:9: no rosbridge answers"):
        nodes("all", url="ws://127.0.0.1:9", patience=0.0)


def test_a_map_that_could_not_be_written_at_the_end_is_refused_at_the_beginning(tmp_path):
    (tmp_path / "nodes.bt").write_bytes(b"surveyed in the lake")
    for name, why in (
        ("nodes.bt", "uwsim did not write it"),
        ("nodes.txt", r"must end in \.bt or \.ot"),
        ("no/nodes.bt", "no folder"),
    ):
        with pytest.raises((OSError, ValueError), match=why):
            nodes("octomap", url="ws://127.0.0.1:9", out=tmp_path / name, patience=0.0)
    assert (tmp_path / "nodes.bt").read_bytes() == b"surveyed in the lake"


def free_port():
    with socket.socket() as held:
        held.bind(("127.0.0.1", 0))
        return held.getsockname()[1]


@contextmanager
def served(port, heard):
    """Serve the lake on a port; yield a function that pings until the nodes have inserted `count` clouds in all."""
    limits = Limits(work_share=1.0)
    with (
        LiveSimulator("lake", paused=True) as live,
        RosbridgeServer(live, port=port, wire="published", limits=limits) as server,
    ):

        def ping_until(count, process):
            until(lambda: INSERTED in server.graph.topics, process)
            server._listener.loop.call_soon_threadsafe(
                lambda: server.graph.subscribe("/test", 0, INSERTED, None, lambda s: heard.append(s.message.data))
            )
            deadline = time.monotonic() + PATIENCE_S
            while heard[-1:] < [count]:
                assert time.monotonic() < deadline and process.poll() is None
                live.step(interval_steps(live.simulator))
                time.sleep(0.05)

        yield ping_until


def test_the_map_outlives_the_connection_and_nodes_reconnect(tmp_path):
    port, heard, out = free_port(), [], tmp_path / "nodes.bt"
    arguments = [UWSIM, "nodes", "--url", f"ws://127.0.0.1:{port}", "--out", out]
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            with served(port, heard) as ping_until:
                assert "octomap" in process.stdout.readline()
                ping_until(3, process)
            until(out.exists, process)
            with served(port, heard) as ping_until:
                ping_until(heard[-1] + 3, process)
            process.send_signal(signal.SIGINT)
            said = process.communicate(timeout=PATIENCE_S)[1]
        finally:
            process.kill()
    assert process.returncode == 0 and "Traceback" not in said
    assert f"uwsim.octomap: ws://127.0.0.1:{port}: the connection has ended; trying to connect again" in said
    assert f"uwsim.octomap: ws://127.0.0.1:{port}: connected again" in said
    assert OccupancyMap.read(out).statistics().occupied_voxels > 0


def test_a_connection_reset_while_a_node_publishes_is_one_sentence_and_is_made_again():
    text = json.dumps({"op": "publish", "topic": "depthArray", "msg": {"data": "5a" * 513}})
    connections, again = [], threading.Event()

    def serve_one(connection):
        connections.append(connection)
        if len(connections) > 1:
            again.set()
        for frame in connection:
            asked = json.loads(frame)
            if asked["op"] == "call_service":
                connection.send(json.dumps({"op": "service_response", "id": asked["id"], "values": {}, "result": True}))
                for _ in range(10):
                    connection.send(text)
                linger = struct.pack("ii", 1, 0)  # reset instead of a closing handshake
                connection.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger)
                connection.socket.close()
                return

    with serve(serve_one, "127.0.0.1", 0) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        url = f"ws://127.0.0.1:{server.socket.getsockname()[1]}"
        arguments = [UWSIM, "nodes", "string_decoder", "--url", url]
        with subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
            try:
                again.wait(PATIENCE_S)
                process.send_signal(signal.SIGINT)
                said = process.communicate(timeout=PATIENCE_S)[1]
            finally:
                process.kill()
        server.shutdown()
    assert len(connections) == 2 and process.returncode == 0
    first, *others = said.splitlines()
    assert first == f"uwsim.string_decoder: {url}: the connection has ended; trying to connect again"
    assert others in ([], [f"uwsim.string_decoder: {url}: connected again"])


def test_a_topic_that_the_server_s_graph_lacks_is_reported_with_its_type():
    def serve_one(connection):
        for frame in connection:
            if (asked := json.loads(frame))["op"] == "call_service":
                values = {"topics": ["/scan"], "types": ["sensor_msgs/LaserScan"]}
                connection.send(json.dumps({"op": "service_response", "id": asked["id"], "values": values}))

    with serve(serve_one, "127.0.0.1", 0) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        node = Node(f"ws://127.0.0.1:{server.socket.getsockname()[1]}")
        node.advertise("scan", SCAN)
        node.advertise("decodedDepth", PUBLISHED_FLOATS)
        assert node.refused(patience_s=0.0) == {"/decodedDepth": "misc/floatarray"}
        node.close()
        server.shutdown()


def test_after_a_restart_of_the_simulation_no_old_transform_places_a_cloud():
    builder = MapBuilder()
    old, new = default_message("builtin_interfaces/msg/Time"), default_message("builtin_interfaces/msg/Time")
    old.sec, new.sec = 300, 2
    away, here = default_message("geometry_msgs/msg/Pose"), default_message("geometry_msgs/msg/Pose")
    away.orientation.w = here.orientation.w = 1.0
    away.position.x = 100.0
    for parent, child in (("odom", "base_footprint"), ("base_footprint", "base_scan")):
        builder.add_transforms(to_transform(away, old, parent, child))
    builder.add_transforms(to_transform(here, new, "odom", "base_footprint"))
    scan = to_scan(type("Decoded", (), {"data": np.full(513, 10.0, np.float32)}), 2, new)
    builder.add_cloud(to_cloud(scan, 2))
    assert builder.insert_ready() == 0
    builder.add_transforms(to_transform(here, new, "base_footprint", "base_scan"))
    assert builder.insert_ready() == 1
    assert builder.map.occupied_voxels()[:, 0].max() < 20.0
