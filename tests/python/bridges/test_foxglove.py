"""Foxglove's server, read by a client that implements the protocol independently."""

import re
from pathlib import Path

import numpy as np
import pytest

from foxglove_client import FoxgloveClient
from ros2_tools import until
from uwsim.bridges.foxglove import FoxgloveServer
from uwsim.bridges.foxglove.places import received_places, true_places
from uwsim.bridges.foxglove.scenes import MapBlocks, Tracks, _grid
from uwsim.channels import Table, channels
from uwsim.channels.delivery.feed import Feed
from uwsim.channels.ros.cdr import schema
from uwsim.channels.ros.messages import from_bytes
from uwsim.link import Carrier
from uwsim.live import LiveSimulator
from uwsim.simulator.simulator import Simulator

ASSETS = Path(__file__).parents[3] / "assets"
SCAN = "sensor_msgs/msg/LaserScan"


@pytest.fixture(scope="module")
def live():
    with LiveSimulator("lake") as live:
        yield live


@pytest.fixture(scope="module")
def server(live):
    table = Table(live.simulator)
    with FoxgloveServer(live, table.channels, table.services, port=0) as server:
        yield server


@pytest.fixture
def client(server):
    with FoxgloveClient(server.url) as client:
        yield client


def test_topics_have_ros_2_s_schemas_and_bytes_and_simulated_time(client, live):
    offered = client.channels["/scan"]
    assert (offered["encoding"], offered["schemaName"], offered["schemaEncoding"]) == ("cdr", SCAN, "ros2msg")
    assert offered["schema"] == schema(SCAN).text
    client.subscribe("/scan")
    time_ns, data = client.next("/scan")
    scan = from_bytes(data, SCAN)
    assert scan.header.frame_id == "base_scan" and len(scan.ranges) == 513
    assert 0 <= time_ns <= live.simulator.time_ns
    client.until(lambda: len(client.times_ns) > 3)
    assert client.times_ns == sorted(client.times_ns) and client.times_ns[-1] <= live.simulator.time_ns


def test_a_late_client_gets_what_is_latched(server):
    for _ in range(2):
        with FoxgloveClient(server.url) as late:
            late.subscribe("/tf_static")
            _, data = late.next("/tf_static")
            assert "odom" in {t.child_frame_id for t in from_bytes(data, "tf2_msgs/msg/TFMessage").transforms}


def test_the_scenes_come_to_each_client(server):
    for _ in range(2):
        with FoxgloveClient(server.url) as client:
            assert client.channels["/scene/lake"]["schemaName"] == "foxglove.SceneUpdate"
            for topic, word in (
                ("/scene/lake", b"bed"),
                ("/scene/vehicles", b"base_link"),
                ("/scene/track", b"rov 0"),
                ("/scene/true_track", b"rov 0"),
            ):
                client.subscribe(topic)
                assert word in client.next(topic)[1]
            client.subscribe("/scene/map")
            assert b"map " in client.next("/scene/map")[1]


def test_what_a_client_publishes_and_calls_is_a_logged_command(client, live):
    assert client.call("/undock", {}) == {"success": True, "message": ""}

    def moves() -> bool:
        client.publish("/cmd_vel", "geometry_msgs/Twist", {"linear": {"x": 0.4}})
        return bool(live.rov.velocity.linear_body_m_s[0] > 0.2)

    until(moves, "motion")
    assert {"undock", "set_effort"} <= {entry.name for entry in live.log}


def test_all_stop_is_a_service_and_commands_meanwhile_are_refused(client, live):
    assert client.call("/all_stop", {"data": True})["success"]
    client.publish("/cmd_vel", "geometry_msgs/Twist", {"linear": {"x": 0.4}})
    client.until(lambda: "all stop is set" in str(client.statuses))
    assert live.rov.all_stopped and not live.rov.effort.any()
    assert client.call("/all_stop", {"data": False})["success"] and not live.rov.all_stopped


def test_a_mistake_is_told_to_the_client(client):
    client.publish("/cmd_tilt", "std_msgs/Float64", {"data": 99.0})
    client.until(lambda: client.statuses)
    assert "cmd_tilt = 99.0 rad: must be in" in client.statuses[-1]
    assert client.call("/simulation/set_speed", {"speed": "fast"})["success"] is False


def test_the_layout_names_topics_that_there_are(client):
    text = (ASSETS / "foxglove/uwsim.json").read_text()
    named = set(re.findall(r'"(/[a-z_/]+)(?:"|\.)', text))
    assert {"/scan", "/cmd_vel", "/undock", "/scene/map"} <= named
    assert named - {"/cmd_vel", "/undock"} <= client.channels.keys()


def test_a_port_that_is_taken_is_an_error_that_names_it(server, live):
    with pytest.raises(OSError, match=f"cannot listen on 127.0.0.1:{server.port}"):
        FoxgloveServer(live, [], port=server.port)
    with pytest.raises(ValueError, match=r"port = 70000: must be in \[0, 65535\]"):
        FoxgloveServer(live, [], port=70000)


def test_the_bed_s_triangles_look_up_and_cover_it():
    heights = np.array([[0.0, 1.0, 0.0], [1.0, 2.0, 1.0]], np.float32)
    vertices, triangles = _grid(heights, 2.0, (10.0, 20.0))
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    assert np.all(normals[:, 2] > 0) and 0.5 * normals[:, 2].sum() == pytest.approx(2 * 2.0 * 2.0)
    assert vertices[:, :2].min(axis=0).tolist() == [10.0, 20.0] and vertices[:, :2].max(axis=0).tolist() == [14.0, 22.0]


def test_a_track_is_sent_in_segments_that_join():
    tracks = Tracks()
    updates = [tracks.grown({"rov": (0.3 * k, 0.0, -5.0)}, k) for k in range(450)]
    assert all(updates) and tracks.grown({"rov": (0.3 * 449, 0.05, -5.0)}, 450) is None
    assert [tracks._positions["rov"][199]] == tracks._positions["rov"][199:200]
    whole = tracks.whole(0).encode()
    assert all(f"rov {number}".encode() in whole for number in range(3)) and b"rov 3" not in whole


def test_a_track_is_the_vehicle_s_own_and_the_true_one_is_a_topic_where_the_truth_is_published():
    with LiveSimulator(Simulator("lake"), paused=True) as live:
        own, true, table = [], [], Table(live.simulator)
        leaves = [
            received_places(live, table.channels, Feed(live))(lambda now, time_ns: own.append((now["rov"], time_ns))),
            true_places(live)(lambda now, time_ns: true.append((now["rov"], time_ns))),
        ]
        live.step(2000)
        for leave in leaves:
            leave()
        rov = live.simulator.rov
        assert own[-1][0] == pytest.approx(rov.estimate.pose.position_world_m, abs=0.05)
        (pose, time_ns), measured = true[-1], {time_ns: place for place, time_ns in own}
        assert pose == pytest.approx(rov.pose.position_world_m, abs=0.05)
        assert 1e-4 < np.linalg.norm(np.subtract(pose, measured[time_ns])) < 1.0
    with LiveSimulator(Simulator("lake"), paused=True) as live:
        for truth in (True, False):
            offered = Table(live.simulator, truth=truth).channels
            with FoxgloveServer(live, offered, port=0) as server, FoxgloveClient(server.url) as client:
                assert "/scene/track" in client.channels
                assert ("/scene/true_track" in client.channels) is truth


def test_over_a_link_a_track_is_what_the_vehicle_told():
    with LiveSimulator(Simulator("lake", link="micromodem"), paused=True) as live:
        sim, told = live.simulator, []
        sim.rov.place((-60.0, -40.0, -12.0))
        with Carrier(live, Table(sim), only=("telemetry",)) as carrier:
            leave = received_places(live, carrier.channels, Feed(live))(
                lambda now, time_ns: told.append((now, time_ns))
            )
            live.step(6000)
            arrived_s = [one.arrived_s for one in sim.link.received("station") if one.topic == "telemetry"]
            leave()
    assert len(told) == len(arrived_s) > 0 and told[0][1] >= 1e9 * arrived_s[0] > 2e9
    assert told[0][0]["rov"] == pytest.approx((-60.0, -40.0, -12.0), abs=0.5)


def test_map_blocks_follow_the_changes(live):
    table = {channel.name: channel for channel in channels(live.simulator)}
    blocks, readings = MapBlocks(), []
    end = Feed(live).listen(table["map_changes"], readings.append)
    until(lambda: readings, "map changes")
    end()
    for reading in list(readings):
        blocks.changed(reading)
    snapshot = table["map_changes"].delivery.catch_up(None)[0]
    drawn = sum(len(cells) for cells in blocks._cells.values())
    assert 0 < drawn <= len(snapshot.cells)
