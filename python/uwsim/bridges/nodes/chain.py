"""The nodes of the paper's Fig. 11, each set up by a function. `mapping/ranging.py` contains the maths.

    depthArray -> string_decoder -> decodedDepth -> scan_publisher -> scan -> laser_to_cloud -> laserPointCloud
    propPos, scanPos -> tf_broadcaster -> tf;   laserPointCloud, tf -> octomap -> a saved .bt
    stateData -> parameter_decoder -> rovParameters

Strings carry no time stamp, so nodes stamp messages with the latest /clock, which the server sends before the topics of
the same step. Each ping is published as one scan. (The paper's node repeated it at 50 Hz, so that each ping counted
several times.)
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from uwsim.bridges.nodes.map_builder import MapBuilder
from uwsim.bridges.nodes.node import Node
from uwsim.channels.families.scans import cloud
from uwsim.channels.ros import build
from uwsim.channels.ros.messages import default_message
from uwsim.mapping import ranging

Publish = Callable[[Any], None]
STRING, FLOATS, POSE = "std_msgs/msg/String", "std_msgs/msg/Float32MultiArray", "geometry_msgs/msg/Pose"
PUBLISHED_FLOATS = "misc/msg/floatarray"  # from the paper's own ROS package, which no distribution includes
SCAN, CLOUD, TF = "sensor_msgs/msg/LaserScan", "sensor_msgs/msg/PointCloud2", "tf2_msgs/msg/TFMessage"
MODEL = 2  # the sonar model until modelTrigger selects a different one
STATE_VALUES = 9  # of stateData
INSERTED = "octomap_node/inserted"
SAVE_S = 1.0  # minimum time between saves


class Clock:
    """The latest simulated time that a node has received."""

    def __init__(self, node: Node) -> None:
        self.stamp = default_message("builtin_interfaces/msg/Time")
        node.subscribe("clock", "rosgraph_msgs/msg/Clock", self._receive)

    def _receive(self, message: Any) -> None:
        self.stamp = message.clock


class Model:
    """The sonar model, as selected by modelTrigger."""

    def __init__(self, node: Node) -> None:
        self.number = MODEL
        node.subscribe("modelTrigger", STRING, self._receive)

    def _receive(self, message: Any) -> None:
        self.number = int(message.data)


def decode(message: Any, model: int, floats: str = FLOATS) -> Any:
    """Convert a depthArray to a decodedDepth of type `floats`. Raises ValueError."""
    decoded = default_message(floats)
    decoded.data = ranging.decode_depth_string(message.data, model)
    return decoded


def decode_state(message: Any, floats: str = FLOATS) -> Any:
    """Convert a stateData to a rovParameters of type `floats`, its values in the same order. Raises ValueError."""
    values = message.data.split("a")
    if len(values) != STATE_VALUES + 1 or values[-1]:
        raise ValueError(
            f"stateData = '{message.data[:80]}': must be {STATE_VALUES} numbers, each followed by the letter a"
        )
    decoded = default_message(floats)
    decoded.data = np.array([float(value) for value in values[:-1]], np.float32)
    return decoded


def to_scan(message: Any, model: int, stamp: Any) -> Any:
    """Convert a decodedDepth to a scan."""
    ranges_m = np.where(np.isnan(message.data), np.float32(np.inf), message.data)
    made = ranging.to_laser_scan(ranges_m, model)
    scan = default_message(SCAN)
    scan.header.stamp, scan.header.frame_id = stamp, made.frame_id
    for name in ("angle_min", "angle_max", "angle_increment", "scan_time", "range_min", "range_max", "ranges"):
        setattr(scan, name, getattr(made, name))
    return scan


def to_cloud(scan: Any, model: int) -> Any:
    """Project a scan to a cloud, with the sonar model's angles, since a LaserScan's angles are rounded to float32."""
    ranges_m = np.where(np.isnan(scan.ranges), np.float32(np.inf), scan.ranges)
    stamp_ns = build.ns_of(scan.header.stamp)
    points = ranging.to_point_cloud(ranging.to_laser_scan(ranges_m, model))
    return cloud({"xyz": points}, stamp_ns, scan.header.frame_id)


def to_transform(pose: Any, stamp: Any, parent: str, child: str) -> Any:
    """Convert a pose to a tf message."""
    stamped = default_message("geometry_msgs/msg/TransformStamped")
    stamped.header.stamp, stamped.header.frame_id, stamped.child_frame_id = stamp, parent, child
    stamped.transform.rotation = pose.orientation
    for axis in "xyz":
        setattr(stamped.transform.translation, axis, getattr(pose.position, axis))
    message = default_message(TF)
    message.transforms = [stamped]
    return message


def string_decoder(node: Node, out: Path, floats: str = FLOATS) -> None:
    """DepthArray -> decodedDepth."""
    publish, model = node.advertise("decodedDepth", floats), Model(node)
    node.subscribe("depthArray", STRING, lambda message: publish(decode(message, model.number, floats)))


def scan_publisher(node: Node, out: Path, floats: str = FLOATS) -> None:
    """DecodedDepth -> scan."""
    publish, model, clock = node.advertise("scan", SCAN), Model(node), Clock(node)
    node.subscribe("decodedDepth", floats, lambda message: publish(to_scan(message, model.number, clock.stamp)))


def laser_to_cloud(node: Node, out: Path, floats: str = FLOATS) -> None:
    """Scan -> laserPointCloud."""
    publish, model = node.advertise("laserPointCloud", CLOUD), Model(node)
    node.subscribe("scan", SCAN, lambda message: publish(to_cloud(message, model.number)))


def tf_broadcaster(node: Node, out: Path, floats: str = FLOATS) -> None:
    """propPos, scanPos -> tf: odom -> base_footprint -> base_scan."""
    publish, clock = node.advertise("tf", TF), Clock(node)

    def send(parent: str, child: str, pose: Any) -> None:
        publish(to_transform(pose, clock.stamp, parent, child))

    node.subscribe("propPos", POSE, partial(send, "odom", "base_footprint"))
    node.subscribe("scanPos", POSE, partial(send, "base_footprint", "base_scan"))


def parameter_decoder(node: Node, out: Path, floats: str = FLOATS) -> None:
    """StateData -> rovParameters."""
    publish = node.advertise("rovParameters", floats)
    node.subscribe("stateData", STRING, lambda message: publish(decode_state(message, floats)))


def octomap(node: Node, out: Path, floats: str = FLOATS) -> None:
    """laserPointCloud, tf -> a map, saved to `out` at the end and, for at most a tenth of the time, before."""
    builder, progress = MapBuilder(), node.advertise(INSERTED, "std_msgs/msg/UInt32")
    due_s = 0.0

    def save() -> None:
        if builder.inserted:
            builder.write(out)

    def insert(add: Publish, message: Any) -> None:
        nonlocal due_s
        add(message)
        if builder.insert_ready():
            begun_s = time.monotonic()
            if begun_s >= due_s:
                save()
                due_s = time.monotonic() + max(SAVE_S, 9.0 * (time.monotonic() - begun_s))
            count = default_message("std_msgs/msg/UInt32")
            count.data = builder.inserted
            progress(count)

    node.finish = save
    node.subscribe("tf", TF, partial(insert, builder.add_transforms))
    node.subscribe("laserPointCloud", CLOUD, partial(insert, builder.add_cloud))


NODES: dict[str, Callable[[Node, Path, str], None]] = {
    node.__name__: node
    for node in (string_decoder, scan_publisher, laser_to_cloud, tf_broadcaster, parameter_decoder, octomap)
}
"""Functions that set up a Node, keyed by node name. Arguments: node, map file (octomap), the type of floats."""
