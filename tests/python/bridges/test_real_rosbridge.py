"""A rosbridge_server accepts what we send: a strict stand-in, and rosbridge_library where it is installed."""

import json
import logging
import math
import re
import subprocess
import threading
from collections.abc import Iterator
from typing import Any

import numpy as np
import orjson
import pytest

from ros1_tools import PYTHON
from strict_rosbridge import StrictRosbridge, strict_rosbridge
from uwsim.bridges import RosbridgeClient
from uwsim.bridges.nodes.chain import NODES
from uwsim.bridges.nodes.node import Node
from uwsim.bridges.rosbridge.encoding import publication
from uwsim.channels import Channel, Table
from uwsim.channels.ros import build
from uwsim.live import LiveSimulator
from uwsim.simulator.simulator import Simulator

HAS_LIBRARY = "import rospy; from rosbridge_library.internal import message_conversion, ros_loader"


@pytest.fixture
def server() -> Iterator[StrictRosbridge]:
    with strict_rosbridge() as server:
        yield server


def wait_for_scans(server: StrictRosbridge, more: int) -> None:
    """Return when the server has received that many more scans."""
    enough = len(server.published["scan"]) + more
    server.wait(lambda: len(server.published["scan"]) >= enough)


def scan(*ranges: float) -> Any:
    return build.message("sensor_msgs/msg/LaserScan", range_max=math.inf, ranges=np.array(ranges, np.float32))


def test_numbers_that_json_lacks_are_words_and_all_others_are_as_before() -> None:
    ranges = [1.1, math.nan, math.inf, -math.inf, 1e-30]
    text = publication(scan(*ranges), "/scan", 1)
    read = json.loads(text)["msg"]
    np.testing.assert_array_equal(np.float32(read["ranges"]), np.float32(ranges))
    assert read["range_max"] == math.inf and "null" not in text
    finite = publication(scan(1.1, 2.2), "/scan", 1)
    assert json.loads(finite)["msg"]["ranges"] == orjson.loads(finite.replace("Infinity", "0"))["msg"]["ranges"]


def test_connect_sends_every_scan_and_reports_what_the_server_refuses(
    server: StrictRosbridge, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.WARNING, "uwsim.rosbridge")
    with LiveSimulator("pool", speed=4.0) as live:
        table = Table(live.simulator)
        wanted = {"odom", "imu", "battery_state", "telemetry", "altitude"}
        sent = [channel for channel in table.channels if channel.name in wanted]
        kind = "sensor_msgs/msg/LaserScan"
        sent.append(Channel("scan", kind, "out", "", rate_hz=50.0, read=lambda sim: scan(1.0, math.inf, math.nan)))
        with RosbridgeClient(live, server.url, channels=sent, services=table.services):
            server.wait(lambda: len(server.published.get("scan", [])) >= 10)
            server.wait(lambda: {"odom", "imu", "battery_state", "altitude"} <= server.published.keys())
            server.wait(lambda: any("refuses" in line for line in caplog.messages))
            wait_for_scans(server, 10)  # the last of them was sent after what was under way
            refused = len(server.refused)
            wait_for_scans(server, 50)
            assert len(server.refused) == refused, "no message on a topic known to be refused"
    np.testing.assert_array_equal(server.published["scan"][0]["ranges"], [1.0, math.inf, math.nan])
    assert math.isnan(server.published["battery_state"][0]["voltage"])
    lacks = "Unable to load the manifest for package uwsim_msgs"
    others = [line for line in server.refused if lacks not in line and "/telemetry" not in line]
    assert server.refused and not others, "only types of packages that it lacks"
    assert server.services["/undock"] == "std_srvs/Trigger" and server.services["/all_stop"] == "std_srvs/SetBool"
    (line,) = [line for line in caplog.messages if "refuses" in line]
    assert re.search(
        r"the server refuses (/[\w/]+, ){2}/[\w/]+ and \d+ more: it lacks the package uwsim_msgs, which", line
    )


def test_the_chain_of_nodes_needs_no_package_that_ros_lacks(server: StrictRosbridge, tmp_path: Any) -> None:
    nodes = {name: Node(server.url) for name in NODES}
    reports: list[str] = []
    stopping = threading.Event()
    threads = []
    for name in reversed(NODES):
        node = nodes[name]
        node.complain = reports.append
        NODES[name](node, tmp_path / "map.bt")
        node.settle()
        threads.append(threading.Thread(target=node.spin, args=(stopping.is_set,)))
        threads[-1].start()
    sim = Simulator("pool")
    table = {channel.name: channel for channel in Table(sim, wire="both").channels}
    vehicle = Node(server.url)
    for name in ("clock", "propPos", "scanPos", "depthArray"):
        vehicle.advertise(name, table[name].type)(table[name].read(sim))
    server.wait(lambda: "octomap_node/inserted" in server.published)
    stopping.set()
    for thread in threads:
        thread.join()
    vehicle.close()
    for node in nodes.values():
        node.finish()
        node.close()
    assert not reports and not server.refused
    assert server.types["decodedDepth"] == "std_msgs/Float32MultiArray"
    assert (tmp_path / "map.bt").stat().st_size > 200


LIBRARY = """
import json, sys
import rospy
from rosbridge_library.internal import message_conversion, ros_loader
for line in sys.stdin:
    kind, frame = line.split(" ", 1)
    message = json.loads(frame)["msg"]
    try:
        instance = ros_loader.get_message_instance(kind)
    except ros_loader.InvalidPackageException:
        continue
    made = message_conversion.populate_instance(message, instance)
    print(made._type, [repr(value) for value in getattr(made, "ranges", [])][:4])
"""


def test_rosbridge_library_itself_accepts_all_standard_messages() -> None:
    found = subprocess.run([PYTHON, "-c", HAS_LIBRARY], capture_output=True, check=False)
    if found.returncode != 0:
        pytest.skip("Debian's Python lacks rosbridge_library or rospy")
    sim = Simulator("pool")
    sim.advance(2.0)
    lines = ["sensor_msgs/LaserScan " + publication(scan(math.inf, math.nan, 1.0), "scan", 1)]
    for channel in Table(sim).channels:
        package, *_, name = channel.type.split("/")
        message = channel.read(sim) if channel.direction == "out" and not channel.delivery.late else None
        if message is not None and package in ("geometry_msgs", "nav_msgs", "sensor_msgs", "std_msgs", "tf2_msgs"):
            lines.append(f"{package}/{name} {publication(message, channel.name, 1)}")
    done = subprocess.run([PYTHON, "-c", LIBRARY], input="\n".join(lines), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    made = done.stdout.splitlines()
    assert "['inf', 'nan', '1.0']" in made[0] and len(made) > 5, "of those packages that are installed"
