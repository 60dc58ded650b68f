"""ROS messages as JSON, CBOR and ROS's own serialisation: conversion is lossless, and errors name the field."""

import base64
import math

import cbor2
import numpy as np
import orjson
import pytest

from uwsim.channels.ros.base64_text import PIECE_BYTES, PIECE_CHARACTERS, from_base64, to_base64
from uwsim.channels.ros.message_out import TYPED_ARRAY_TAGS
from uwsim.channels.ros.message_types import ros1_typestore
from uwsim.channels.ros.messages import (
    default_message,
    from_bytes,
    from_plain,
    resolve,
    spelled,
    to_bytes,
    to_plain,
    typed_array,
    typestore,
)

SCAN = "sensor_msgs/msg/LaserScan"


def through_json(plain):
    return orjson.loads(orjson.dumps(plain, option=orjson.OPT_SERIALIZE_NUMPY))


def scan(*ranges):
    message = default_message(SCAN)
    message.header.stamp.sec, message.header.frame_id = 12, "base_scan"
    message.ranges = np.array(ranges, np.float32)
    return message


def test_every_type_survives_json_and_cbor():
    for name in typestore().fielddefs:
        message = default_message(name)
        for ros in (1, 2):
            plain = to_bytes(message, ros)
            assert to_bytes(from_plain(name, through_json(to_plain(message, ros))), ros) == plain
        assert to_bytes(from_plain(name, cbor2.loads(cbor2.dumps(to_plain(message, 2, "cbor"))))) == plain
        assert to_bytes(from_plain(name, {})) == plain  # missing fields get default values


def test_the_two_generations_differ_in_header_times_and_camera_matrices():
    stamped = scan()
    assert to_plain(stamped, ros=1)["header"] == {"seq": 0, "stamp": {"secs": 12, "nsecs": 0}, "frame_id": "base_scan"}
    assert to_plain(stamped, ros=2)["header"] == {"stamp": {"sec": 12, "nanosec": 0}, "frame_id": "base_scan"}
    for header in ({"seq": 7, "stamp": {"secs": 3, "nsecs": 5}}, {"stamp": {"sec": 3, "nanosec": 5}}):
        stamp = from_plain(SCAN, {"header": header}).header.stamp
        assert (stamp.sec, stamp.nanosec) == (3, 5)
    camera = from_plain("sensor_msgs/msg/CameraInfo", {"K": list(range(9))})
    assert to_plain(camera, ros=2)["k"].tolist() == to_plain(camera, ros=1)["K"].tolist() == list(range(9))


def test_names_of_types():
    assert resolve("sensor_msgs/LaserScan") == (SCAN, None)
    assert resolve(SCAN) == (SCAN, 2)
    assert [spelled(SCAN, 1), spelled(SCAN, 2)] == ["sensor_msgs/LaserScan", SCAN]
    for name in ("LaserScan", "a/b/c", "", 3, None, "sensor_msgs/srv/LaserScan"):
        with pytest.raises(ValueError, match="must be the name of a message type"):
            resolve(name)
    with pytest.raises(ValueError, match="type = 'no_msgs/Such': unknown message type"):
        resolve("no_msgs/Such")


def test_json_has_no_infinity_and_cbor_has():
    message = scan(1.5, math.inf, math.nan)
    assert through_json(to_plain(message))["ranges"] == [1.5, None, None]
    tag = to_plain(message, form="cbor")["ranges"]
    np.testing.assert_array_equal(typed_array(tag), message.ranges)
    assert np.isnan(from_plain(SCAN, {"ranges": [1.5, None]}).ranges[1])
    assert np.isnan(from_plain(SCAN, {"range_max": None}).range_max)
    assert from_plain(SCAN, {"header": {"seq": None, "stamp": None, "frame_id": None}}).header.frame_id == ""


@pytest.mark.parametrize("size", [0, 1, 2, 3, PIECE_BYTES - 1, PIECE_BYTES, PIECE_BYTES + 1, 2 * PIECE_BYTES, 10**6])
def test_base64_in_pieces_is_base64(size):
    data = bytes(k * k % 251 for k in range(size))
    text = base64.b64encode(data).decode()
    assert to_base64(memoryview(data)) == text and from_base64(text) == data
    for wrong in ("=" + text, text + "A", text[: PIECE_CHARACTERS - 2] + "==" + text[PIECE_CHARACTERS:] + "AAAA", "\n"):
        with pytest.raises(ValueError, match=r"(?i)padding|data|character"):
            from_base64(wrong)


def test_bytes_are_base64_in_json_and_bytes_in_cbor():
    image = default_message("sensor_msgs/msg/CompressedImage")
    image.data = np.frombuffer(b"\x00\xffJPEG", np.uint8)
    assert base64.b64decode(to_plain(image)["data"]) == to_plain(image, form="cbor")["data"] == b"\x00\xffJPEG"
    for sent in (base64.b64encode(b"\x00\xff").decode(), b"\x00\xff", [0, 255], [0.0, 255.0]):
        assert from_plain("sensor_msgs/msg/CompressedImage", {"data": sent}).data.tolist() == [0, 255]


def test_typed_arrays_are_those_of_rfc_8746():
    assert {"float32": 85, "float64": 86, "uint32": 70, "int16": 77}.items() <= TYPED_ARRAY_TAGS.items()
    big_endian = cbor2.CBORTag(81, np.array([1.0, -2.5], ">f4").tobytes())
    assert from_plain(SCAN, {"ranges": big_endian}).ranges.tolist() == [1.0, -2.5]
    for tag in (cbor2.CBORTag(85, b"123"), cbor2.CBORTag(999, b""), cbor2.CBORTag(85, "text")):
        with pytest.raises(ValueError, match="typed array of RFC 8746"):
            from_plain(SCAN, {"ranges": tag})


def test_raw_bytes_are_those_of_the_two_stores():
    message = scan(1.0, 2.0)
    assert from_bytes(to_bytes(message), SCAN).ranges.tolist() == [1.0, 2.0]
    read = ros1_typestore().deserialize_ros1(to_bytes(message, ros=1), SCAN)
    assert (read.header.seq, read.header.stamp.sec, read.ranges.tolist()) == (0, 12, [1.0, 2.0])
    with pytest.raises(ValueError, match="not a valid serialisation"):
        from_bytes(b"\x00\x01\x00\x00\xff", SCAN)


@pytest.mark.parametrize(
    ("name", "plain", "complaint"),
    [
        ("geometry_msgs/msg/Twist", {"linear": {"x": "fast"}}, r"msg.linear.x = 'fast': must be a number \(float64\)"),
        ("geometry_msgs/msg/Twist", {"linear": {"x": True}}, r"msg.linear.x = True: must be a number"),
        ("geometry_msgs/msg/Twist", {"linear": 3}, r"msg.linear = 3: must be an object \(geometry_msgs/msg/Vector3\)"),
        ("geometry_msgs/msg/Twist", {"lin": {}}, "msg.lin: geometry_msgs/msg/Twist has no such field; it has: linear"),
        ("geometry_msgs/msg/Twist", [1], "msg = list: must be an object"),
        ("std_msgs/msg/UInt8", {"data": 256}, r"msg.data = 256: must be a whole number in \[0, 255\]"),
        ("std_msgs/msg/UInt8", {"data": 1.5}, "msg.data = 1.5: must be a whole number"),
        ("std_msgs/msg/Bool", {"data": 1}, "msg.data = 1: must be true or false"),
        ("std_msgs/msg/String", {"data": 1}, "msg.data = 1: must be a string"),
        (SCAN, {"ranges": [1, "2"]}, r"msg.ranges\[1\] = '2': must be a number, each \(float32\[\]\)"),
        (SCAN, {"ranges": [[1], [2]]}, r"msg.ranges\[0\] = list: must be a number"),
        (SCAN, {"ranges": [True]}, r"msg.ranges\[0\] = True"),
        (SCAN, {"ranges": 3}, "msg.ranges = 3: must be a list"),
        ("std_msgs/msg/UInt8MultiArray", {"data": [1, 300]}, r"msg.data\[1\] = 300: must be a whole number in"),
        ("std_msgs/msg/UInt8MultiArray", {"data": "%"}, "must be base64"),
        ("sensor_msgs/msg/CameraInfo", {"k": [1.0]}, r"msg.k: 1 elements: must be 9 \(float64\[9\]\)"),
        ("sensor_msgs/msg/JointState", {"name": ["a", 1]}, r"msg.name\[1\] = 1: must be a string"),
        ("tf2_msgs/msg/TFMessage", {"transforms": [{}, {"child_frame_id": 1}]}, r"msg.transforms\[1\].child_frame_id"),
    ],
)
def test_what_is_wrong_is_named(name, plain, complaint):
    with pytest.raises(ValueError, match=complaint):
        from_plain(name, plain)
