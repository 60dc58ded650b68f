"""`uwsim map from` a bag that others wrote: clouds and scans where the transforms of their times put them."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from command_line import uwsim as command
from uwsim.mapping import OccupancyMap

ROS2, ROS1 = get_typestore(Stores.ROS2_JAZZY), get_typestore(Stores.ROS1_NOETIC)
CLOUD, SCAN, TF = "sensor_msgs/msg/PointCloud2", "sensor_msgs/msg/LaserScan", "tf2_msgs/msg/TFMessage"
ROS1.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", TF))
ACROSS = np.column_stack([np.zeros(101), np.linspace(-5.0, 5.0, 101), np.full(101, -6.1)])
"""A line across, below the sensor, in its frame."""


def header(store: Any, time_s: float, frame: str) -> Any:
    stamp = store.types["builtin_interfaces/msg/Time"](sec=int(time_s), nanosec=round(1e9 * (time_s % 1)))
    more = {"seq": 0} if store is ROS1 else {}
    return store.types["std_msgs/msg/Header"](stamp=stamp, frame_id=frame, **more)


def transform(store: Any, time_s: float, parent: str, child: str, xyz: Any, yaw: float = 0.0) -> Any:
    t, at = store.types, dict(zip("xyz", map(float, xyz), strict=True))
    turn = t["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=np.sin(yaw / 2), w=np.cos(yaw / 2))
    moved = t["geometry_msgs/msg/Transform"](translation=t["geometry_msgs/msg/Vector3"](**at), rotation=turn)
    stamped = t["geometry_msgs/msg/TransformStamped"](
        header=header(store, time_s, parent), child_frame_id=child, transform=moved
    )
    return t[TF](transforms=[stamped])


def cloud(store: Any, time_s: float, kind: int = 7, datatype: str = "<f4") -> Any:
    rows = np.zeros(len(ACROSS), [("pad", "u1", 5), *((axis, datatype) for axis in "xyz"), ("intensity", "<f4")])
    for axis, values in zip("xyz", ACROSS.T, strict=True):
        rows[axis] = values
    step, size = rows.dtype.itemsize, np.dtype(datatype).itemsize
    fields = [
        store.types["sensor_msgs/msg/PointField"](name=axis, offset=5 + size * k, datatype=kind, count=1)
        for k, axis in enumerate("xyz")
    ]
    return store.types[CLOUD](
        header=header(store, time_s, "sonar"), height=1, width=len(rows), fields=fields, point_step=step,
        is_bigendian=datatype[0] == ">", row_step=step * len(rows), data=np.frombuffer(rows.tobytes(), np.uint8),
        is_dense=True,
    )  # fmt: skip


def scan(store: Any, time_s: float) -> Any:
    ranges = np.full(91, 4.05, np.float32)
    ranges[:5] = np.inf
    return store.types[SCAN](
        header=header(store, time_s, "sonar"), angle_min=-0.5, angle_max=0.4, angle_increment=0.01, time_increment=0.0,
        scan_time=0.0, range_min=0.1, range_max=30.0, ranges=ranges, intensities=np.empty(0, np.float32),
    )  # fmt: skip


Messages = list[tuple[str, str, float, Any]]


def written(path: Path, writer: Any, store: Any, serialize: Any, messages: Messages) -> Path:
    with writer:
        kinds = {topic: kind for topic, kind, *_ in messages}
        known = {topic: writer.add_connection(topic, kind, typestore=store) for topic, kind in kinds.items()}
        for topic, kind, time_s, message in messages:
            writer.write(known[topic], round(1e9 * time_s), serialize(message, kind))
    return path


def write1(path: Path, messages: Messages) -> Path:
    return written(path, Writer1(path), ROS1, ROS1.serialize_ros1, messages)


def write2(path: Path, messages: Messages, plugin: StoragePlugin = StoragePlugin.MCAP) -> Path:
    return written(path, Writer(path, version=9, storage_plugin=plugin), ROS2, ROS2.serialize_cdr, messages)


def built(source: Path, folder: Path, *options: object) -> tuple[OccupancyMap, str]:
    done = command("map", "from", source, "--out", folder / "map.bt", "--voxel", 0.2, *options)
    assert done.returncode == 0, done.stderr
    return OccupancyMap.read(folder / "map.bt"), done.stdout


def dive(store: Any) -> list[tuple[str, str, float, Any]]:
    """A sonar that is mounted 0.5 m ahead of a body, which goes 1 m/s along x at 2 m; transforms only each second."""
    return [
        ("/tf_static", TF, 0.0, transform(store, 0.0, "body", "sonar", (0.5, 0, 0))),
        *(("/tf", TF, float(k), transform(store, k, "map", "body", (k, 0, -2))) for k in range(11)),
        *(("/cloud", CLOUD, 0.25 + k, cloud(store, 0.25 + k)) for k in range(10)),
    ]  # fmt: skip


@pytest.mark.parametrize("kind", ["mcap", "sqlite", "ros1"])
def test_clouds_are_where_interpolated_transforms_put_them(kind: str, tmp_path: Path) -> None:
    if kind == "ros1":
        path = write1(tmp_path / "dive.bag", dive(ROS1))
    else:
        path = write2(tmp_path / "bag", dive(ROS2), StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3)
    found, printed = built(path, tmp_path)
    wanted = OccupancyMap(resolution_m=0.2)
    for k in range(10):
        at = np.array([0.75 + k, 0.0, -2.0])
        wanted.insert_scan((ACROSS.astype(np.float32) + at.astype(np.float32)), at, np.inf)
    assert found.count() == wanted.count()
    np.testing.assert_array_equal(found.occupied_voxels(), wanted.occupied_voxels())
    assert "frame 'map', the root of the transforms of 'sonar'" in printed and "10 clouds" in printed


def test_what_is_not_taken_is_counted_or_named(tmp_path: Path) -> None:
    late = [("/cloud", CLOUD, 30.0, cloud(ROS2, 30.0)), ("/cloud", CLOUD, 1.5, cloud(ROS2, 1.5, 2, "<i4"))]
    other = [("/scan", SCAN, 2.5, scan(ROS2, 2.5))]
    path = write2(tmp_path / "bag", [*dive(ROS2), *late, *other])
    _, printed = built(path / "bag.mcap", tmp_path)
    assert "left out: /scan: --topic chooses it" in printed
    assert "left out: 1 of 12 messages: the transforms of 'body' do not reach its time" in printed
    assert "left out: 1 of 12 messages: it has no x, y and z of float32 or float64" in printed
    found, _ = built(path, tmp_path, "--topic", "/scan", "--frame", "body")
    places = found.occupied_voxels()
    assert np.hypot(places[:, 0] - 0.5, places[:, 1]) == pytest.approx(4.05, abs=0.2)  # ahead of the body


@pytest.mark.parametrize("datatype, kind", [(">f4", 7), ("<f8", 8)])
def test_clouds_of_any_order_of_bytes_are_read(datatype: str, kind: int, tmp_path: Path) -> None:
    path = write2(tmp_path / "bag", [("/cloud", CLOUD, 0.0, cloud(ROS2, 0.0, kind, datatype))])
    found, printed = built(path, tmp_path)
    assert "frame 'sonar'" in printed
    assert found.occupied_voxels()[:, 2] == pytest.approx(-6.1, abs=0.1)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--topic", "/lidar"), "--topic /lidar: must be one of /cloud"),
        (("--frame", "odom"), "no message of /cloud can be placed: no transform leads from 'map' to 'odom'"),
        (("--vehicle", "rov"), "--vehicle: is not for"),
    ],
)
def test_a_bag_that_cannot_be_mapped_is_refused_in_one_line(
    options: tuple[str, str], words: str, tmp_path: Path
) -> None:
    path = write2(tmp_path / "bag", dive(ROS2))
    done = command("map", "from", path, "--out", tmp_path / "map.bt", *options)
    assert done.returncode == 1 and words in done.stderr and len(done.stderr.splitlines()) == 1
    assert not (tmp_path / "map.bt").exists()
