"""The paper's processing chain as processes over rosbridge: its map is byte-identical to the single-process map."""

import json
import signal
import socket
import struct
import threading
from contextlib import contextmanager, suppress

import numpy as np
import pytest
from websockets.sync.server import serve

from listening_sockets import free_port
from uwsim.bridges import RosbridgeServer
from uwsim.bridges.cli.nodes import NODES as OFFERED
from uwsim.bridges.cli.nodes import nodes
from uwsim.bridges.nodes.chain import (
    INSERTED,
    NODES,
    PUBLISHED_FLOATS,
    SCAN,
    decode,
    decode_state,
    to_cloud,
    to_scan,
    to_transform,
)
from uwsim.bridges.nodes.map_builder import MapBuilder
from uwsim.bridges.nodes.node import Node
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.channels import channels
from uwsim.channels.ros.messages import default_message
from uwsim.live import LiveSimulator
from uwsim.mapping import OccupancyMap
from uwsim.simulator.simulator import Simulator
from waiting import until

PINGS = 44  # a short survey: two lanes, each with a turn
LANE = 22


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


@contextmanager
def served(port, heard):
    """Serve the lake; yield it, and a function that begins to add the numbers of inserted clouds to `heard`."""
    limits = Limits(work_share=1.0)
    with (
        LiveSimulator("lake", paused=True) as live,
        RosbridgeServer(live, port=port, wire="published", limits=limits) as server,
    ):

        def listen():
            until(lambda: INSERTED in server.graph.topics)
            server._listener.loop.call_soon_threadsafe(
                lambda: server.graph.subscribe("/test", 0, INSERTED, None, lambda s: heard.append(s.message.data))
            )

        yield live, listen


def test_six_processes_make_the_map_of_one(tmp_path, programs):
    heard, port = [], free_port()
    url, out = f"ws://127.0.0.1:{port}", tmp_path / "nodes.bt"
    with (
        served(port, heard) as (lake, listen),
        programs.greeted("ros", "nodes", "--url", url, "--out", out) as (process, line),
    ):
        assert "octomap" in line
        listen()
        for ping in range(PINGS):
            if ping == 1:
                lake.rov.undock()
            lake.rov.set_effort(**effort(ping))
            lake.step(0 if ping == 0 else interval_steps(lake.simulator))
            until(lambda ping=ping: heard[-1:] == [ping + 1])
        assert process.end(signal.SIGINT)[0] == 0
    flown = chain_in_process(tmp_path / "chain.bt")
    assert np.ptp(flown, axis=0)[:2].min() > 3.0
    assert out.read_bytes() == (tmp_path / "chain.bt").read_bytes()
    assert len(out.read_bytes()) > 20_000


def test_the_panels_string_becomes_its_nine_numbers():
    message = default_message("std_msgs/msg/String")
    message.data = "0.5a1E-05a24a101.325a0aInfinitya41.5a7a99.5a"
    expected = [0.5, 1e-5, 24.0, 101.325, 0.0, np.inf, 41.5, 7.0, 99.5]
    np.testing.assert_array_equal(decode_state(message).data, np.float32(expected))
    message.data = "0.5a1"
    with pytest.raises(ValueError, match="must be 9 numbers, each followed by the letter a"):
        decode_state(message)


def test_the_commands_choices_are_the_nodes():
    assert tuple(NODES) == OFFERED


def test_the_map_is_octomaps_own():
    assert MapBuilder().map.engine == "octomap"


def stamp_of(seconds):
    stamp = default_message("builtin_interfaces/msg/Time")
    stamp.sec = seconds
    return stamp


def placed(x=0.0):
    pose = default_message("geometry_msgs/msg/Pose")
    pose.position.x, pose.orientation.w = x, 1.0
    return pose


def cloud_at(stamp):
    return to_cloud(to_scan(type("Decoded", (), {"data": np.full(513, 10.0, np.float32)}), 2, stamp), 2)


LINKS = ("odom", "base_footprint"), ("base_footprint", "base_scan")


def test_clouds_wait_for_the_transforms_of_their_time():
    builder, stamp = MapBuilder(), stamp_of(5)
    builder.add_cloud(cloud_at(stamp))
    for link, expected in zip(LINKS, (0, 1), strict=True):
        builder.add_transforms(to_transform(placed(), stamp, *link))
        assert builder.insert_ready() == expected


def test_after_a_restart_of_the_simulation_no_old_transform_places_a_cloud():
    builder, new = MapBuilder(), stamp_of(2)
    for link in LINKS:
        builder.add_transforms(to_transform(placed(100.0), stamp_of(300), *link))
    builder.add_transforms(to_transform(placed(), new, *LINKS[0]))
    builder.add_cloud(cloud_at(new))
    assert builder.insert_ready() == 0
    builder.add_transforms(to_transform(placed(), new, *LINKS[1]))
    assert builder.insert_ready() == 1
    assert builder.map.occupied_voxels()[:, 0].max() < 20.0


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


def test_the_map_outlives_the_connection_and_nodes_reconnect(tmp_path, programs):
    port, heard, out = free_port(), [], tmp_path / "nodes.bt"
    url = f"ws://127.0.0.1:{port}"

    def pings(lake, count):
        """Ping once more, and wait a little for the cloud, which is lost while the nodes are not all connected."""
        before = len(heard)
        lake.step(interval_steps(lake.simulator))
        with suppress(AssertionError):
            until(lambda: len(heard) > before, limit_s=1.0)
        return heard[-1:] >= [count]

    with programs.running("ros", "nodes", "--url", url, "--out", out) as process:
        with served(port, heard) as (lake, listen):
            assert "octomap" in process.stdout.readline()
            listen()
            until(lambda: pings(lake, 3))
        until(out.exists)
        with served(port, heard) as (other, listen):
            listen()
            end = heard[-1] + 3
            until(lambda: pings(other, end))
        code, said = process.end(signal.SIGINT)
    assert code == 0 and "Traceback" not in said
    assert f"uwsim.octomap: {url}: the connection has ended; trying to connect again" in said
    assert f"uwsim.octomap: {url}: connected again" in said
    assert OccupancyMap.read(out).statistics().occupied_voxels > 0


@contextmanager
def answered(serve_one):
    """Serve each connection by a function; yield the URL."""
    with serve(serve_one, "127.0.0.1", 0) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"ws://127.0.0.1:{server.socket.getsockname()[1]}"
        server.shutdown()


def test_a_connection_reset_while_a_node_publishes_is_one_sentence_and_is_made_again(programs):
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

    with answered(serve_one) as url, programs.running("ros", "nodes", "string_decoder", "--url", url) as process:
        assert again.wait(180.0)
        code, said = process.end(signal.SIGINT)
    assert len(connections) == 2 and code == 0
    first, *others = said.splitlines()
    assert first == f"uwsim.string_decoder: {url}: the connection has ended; trying to connect again"
    assert others in ([], [f"uwsim.string_decoder: {url}: connected again"])


def test_a_topic_that_the_server_s_graph_lacks_is_reported_with_its_type():
    def serve_one(connection):
        for frame in connection:
            if (asked := json.loads(frame))["op"] == "call_service":
                values = {"topics": ["/scan"], "types": ["sensor_msgs/LaserScan"]}
                connection.send(json.dumps({"op": "service_response", "id": asked["id"], "values": values}))

    with answered(serve_one) as url:
        node = Node(url)
        node.advertise("scan", SCAN)
        node.advertise("decodedDepth", PUBLISHED_FLOATS)
        assert node.refused(patience_s=0.0) == {"/decodedDepth": "misc/floatarray"}
        node.close()
