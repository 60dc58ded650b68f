"""ROS 2 message bytes: built once, equal to those of rosbags, and described as ROS 2 does."""

import dataclasses
import re
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from rosbags.serde import SerdeError

from channel_tools import table
from uwsim.channels.delivery.feed import Feed, Reading
from uwsim.channels.ros import cdr
from uwsim.channels.ros.cdr_layout import writer
from uwsim.channels.ros.message_out import default_message
from uwsim.channels.ros.message_types import typestore
from uwsim.live import LiveSimulator
from uwsim.simulator.simulator import Simulator


def test_a_schema_has_all_that_the_type_contains_and_ros_2_s_hash() -> None:
    scan = cdr.schema("sensor_msgs/msg/LaserScan")
    assert "MSG: std_msgs/Header" in scan.text and "float32[] ranges" in scan.text
    # As printed by `ros2 topic info -v` of Jazzy for std_msgs/msg/String.
    known = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
    assert cdr.schema("std_msgs/msg/String").type_hash == known
    hashes = {cdr.schema(name).type_hash for name in ("sensor_msgs/msg/LaserScan", "marine_acoustic_msgs/msg/Dvl")}
    assert len(hashes) == 2 and all(re.fullmatch("RIHS01_[0-9a-f]{64}", text) for text in hashes)


def test_threads_that_ask_at_once_get_the_same_bytes(monkeypatch: pytest.MonkeyPatch) -> None:
    sim, made, encode = Simulator("pool"), [], cdr.encode
    channel = table(sim)["odom"]
    reading = Reading(channel, channel.read(sim), sim.time_ns, sim.tick)
    monkeypatch.setattr("uwsim.channels.delivery.feed.encode", lambda message: made.append(message) or encode(message))
    with ThreadPoolExecutor(8) as threads:
        found = list(threads.map(lambda _: reading.cdr, range(8)))
    assert len(made) == 1 and all(data is found[0] for data in found)


def test_a_feed_reads_once_for_all_and_only_while_somebody_listens() -> None:
    first, second, early, late = (list[Reading]() for _ in range(4))
    with LiveSimulator("pool", paused=True) as live:
        channel, static = table(live.simulator)["odom"], table(live.simulator)["tf_static"]
        feed = Feed(live)
        leave = [feed.listen(channel, heard.append) for heard in (first, second)]
        live.step(20)
        assert first[1:] and all(a is b for a, b in zip(first[1:], second[-len(first) + 1 :], strict=True))
        assert [reading.time_ns for reading in first] == sorted({reading.time_ns for reading in first})
        for end in leave:
            end()
        count = len(first)
        live.step(20)
        assert len(first) == count
        feed.listen(static, early.append)
        live.step(1)
        feed.listen(static, late.append)
        assert late == early and len(late) == 1
        assert typestore().types["tf2_msgs/msg/TFMessage"] is type(late[0].message)


def test_messages_that_are_written_at_once_are_those_of_rosbags() -> None:
    """Messages of every type with other texts and arrays, which move and fill what follows them."""
    store, at_once = typestore(), []
    for name in store.fielddefs:
        for length in (0, 1, 6):
            message = filled(default_message(name), length)
            if (write := writer(name, store, cdr.HEADER)) is not None:
                data = store.serialize_cdr(message, name)
                assert write(message) == bytes(data) + b"\0" * (-len(data) % 4), name
                at_once.append(name)
    assert {"sensor_msgs/msg/Imu", "nav_msgs/msg/Odometry", "std_msgs/msg/Float64"} <= set(at_once)
    imu = default_message("sensor_msgs/msg/Imu")
    imu.orientation_covariance = np.zeros(8)
    with pytest.raises(SerdeError, match="array length"):
        cdr.encode(imu)


def filled(message: Any, length: int) -> Any:
    """Return a message with texts of a length, and arrays and floats of ones, at any depth."""
    for field in dataclasses.fields(message):
        value = getattr(message, field.name)
        if isinstance(value, str):
            setattr(message, field.name, "ä" * length)
        elif isinstance(value, np.ndarray):
            value[:] = 1
        elif isinstance(value, float):
            setattr(message, field.name, 1.0 + length)
        elif dataclasses.is_dataclass(value):
            filled(value, length)
    return message
