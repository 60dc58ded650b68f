"""Bags of others: a map from their clouds or laser scans, each placed by the transforms of its time.

Frames and interpolation as in ROS's tf2: between two transforms of a link, positions are interpolated linearly and
rotations along the shorter arc; static transforms hold at any time.
"""

from __future__ import annotations

import tempfile
from bisect import bisect_left
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from uwsim.base.arrays import Floats
from uwsim.channels.ros import build
from uwsim.mapping import OccupancyMap, ranging
from uwsim.recording.contents import NOT_OURS
from uwsim.recording.reader import Recording
from uwsim.scenario.read.contained import run_contained

TRANSFORMS = ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage")
METADATA, LEVELS_MAX, VOXEL_M = "metadata.yaml", 100, 0.2
LATE_NS = 100_000_000
"""A cloud this much outside the transforms of a link still takes the nearest."""
FLOATS = {7: "f4", 8: "f8"}
"""Types of PointField that coordinates have, without their order of bytes."""


@dataclass
class Link:
    """The transforms from a child frame to its parent, by time. is_static: holds at any time."""

    parent: str
    is_static: bool
    times_ns: list[int] = field(default_factory=list)
    poses: list[tuple[Floats, Floats]] = field(default_factory=list)

    def matrix(self, time_ns: int) -> Floats | None:
        """Return the transform (4, 4) at a time, None outside the times that are known."""
        if self.is_static:
            return _matrix(*self.poses[-1])
        at = bisect_left(self.times_ns, time_ns)
        if at < len(self.times_ns) and self.times_ns[at] == time_ns:
            return _matrix(*self.poses[at])
        if 0 < at < len(self.times_ns):
            before, after = self.times_ns[at - 1 : at + 1]
            share = (time_ns - before) / (after - before)
            (start, turn), (end, other) = self.poses[at - 1 : at + 1]
            between = Slerp([0.0, 1.0], Rotation.from_quat([turn, other]))(share).as_quat()
            return _matrix(start + share * (end - start), between)
        nearest = 0 if at == 0 else -1
        return _matrix(*self.poses[nearest]) if abs(time_ns - self.times_ns[nearest]) <= LATE_NS else None


@dataclass
class FromBag:
    """A map from a bag. notes: a line for each thing that was chosen, assumed or left out."""

    map: OccupancyMap
    scans: int
    notes: list[str]


def foreign_bag(path: Path) -> Path | None:
    """Return the bag of ROS 1 or 2 that a path is, or is a file of, unless uwsim wrote it as a recording; None if none.

    Raises ValueError for a file without the metadata.yaml of its folder, and OSError.
    """
    if path.suffix == ".bag" or (path.is_dir() and (path / METADATA).is_file()):
        return path
    if path.is_dir():
        raise ValueError(f"'{path}': has no {METADATA}: must be the folder of a bag")
    if path.suffix == ".db3" or (path.suffix == ".mcap" and not _is_ours(path)):
        if not (path.parent / METADATA).is_file():
            remedy = f"`ros2 bag reindex {path.parent}` writes it"
            raise ValueError(f"'{path}': was not written by uwsim, and no {METADATA} is beside it: {remedy}")
        return path.parent
    return None


def _is_ours(path: Path) -> bool:
    try:
        Recording(path)
    except ValueError as error:
        return NOT_OURS not in str(error)
    return True


def map_from_bag(path: Path, *, topic: str | None, frame: str | None, voxel_m: float) -> FromBag:
    """Return the map of a bag's clouds or scans.

    topic: by default that of most messages. frame: in which the map is, by default the one at the root of the cloud's
    transforms. Raises ValueError or OSError.
    """
    made = run_contained(Path(__file__), "rosbags", str(path), topic, frame, voxel_m, reads=[path])
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "map.ot"
        file.write_bytes(made["map"].tobytes())
        return FromBag(OccupancyMap.read(file), int(made["scans"]), made["notes"].tolist())


def read(path: str, topic: str | None, frame: str | None, voxel_m: float) -> dict[str, NDArray[Any]]:
    """Return the map, its number of scans, and the notes: the script of a contained process."""
    with opened_bag(Path(path)) as bag:
        return _read(bag, Path(path), topic, frame, voxel_m)


@contextmanager
def opened_bag(path: Path) -> Iterator[Any]:
    """Open a bag by rosbags, which raises errors of many types for a damaged one. Raises ValueError, OSError."""
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    try:
        with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as bag:
            yield bag
    except (OSError, ValueError, MemoryError):
        raise
    except Exception as error:
        raise ValueError(f"'{path}': is no bag that can be read: {type(error).__name__}: {error!s:.100}") from None


def _read(bag: Any, path: Path, topic: str | None, frame: str | None, voxel_m: float) -> dict[str, NDArray[Any]]:
    counts = {each.topic: each.msgcount for each in bag.connections if each.msgtype in POINTS_OF}
    if not counts:
        kinds = ", ".join(sorted({each.msgtype for each in bag.connections})) or "none"
        raise ValueError(f"'{path}': has no {' or '.join(POINTS_OF)}; there are: {kinds}")
    if topic is not None and topic not in counts:
        raise ValueError(f"--topic {topic}: must be one of {', '.join(sorted(counts))}")
    chosen = topic or max(sorted(counts), key=lambda each: counts[each])
    notes = [f"read: {chosen}"]
    notes += [f"left out: {each}: --topic chooses it" for each in sorted(counts) if each != chosen]
    links = _links(bag)
    occupancy, scans, dropped = OccupancyMap(resolution_m=voxel_m), 0, Counter[str]()
    for message, kind in _messages(bag, chosen):
        own = message.header.frame_id.lstrip("/")
        if frame is None:
            frame = _root(links, own)
            notes.append(f"assumed: the map is in frame '{frame}', the root of the transforms of '{own}'")
        placed = _placed(links, own, frame.lstrip("/"), build.ns_of(message.header.stamp))
        if isinstance(placed, str):
            dropped[placed] += 1
            continue
        points = POINTS_OF[kind](message)
        if points is None:
            dropped["it has no x, y and z of float32 or float64"] += 1
            continue
        occupancy.insert_scan(ranging.transform_points(points, placed), placed[:3, 3], np.inf)
        scans += 1
    notes += [f"left out: {count} of {counts[chosen]} messages: {why}" for why, count in dropped.items()]
    if not scans:
        raise ValueError(f"'{path}': no message of {chosen} can be placed: {next(iter(dropped), 'it has none')}")
    octree = np.frombuffer(occupancy.to_bytes("ot"), np.uint8)
    return {"map": octree, "scans": np.array(scans), "notes": np.array(notes, str)}


def _messages(bag: Any, *topics: str) -> Iterator[tuple[Any, str]]:
    chosen = [each for each in bag.connections if each.topic in topics]
    for connection, _, data in bag.messages(connections=chosen):
        yield bag.deserialize(data, connection.msgtype), connection.msgtype


def _links(bag: Any) -> dict[str, Link]:
    """Return the links of all transforms by their child frame, in the order of time."""
    links: dict[str, Link] = {}
    found = [each for each in bag.connections if each.msgtype in TRANSFORMS]
    for connection, _, data in bag.messages(connections=found) if found else ():
        for stamped in bag.deserialize(data, connection.msgtype).transforms:
            child, parent = stamped.child_frame_id.lstrip("/"), stamped.header.frame_id.lstrip("/")
            link = links.setdefault(child, Link(parent, connection.topic.endswith("tf_static")))
            moved, turned = stamped.transform.translation, stamped.transform.rotation
            quaternion = np.array([turned.x, turned.y, turned.z, turned.w])
            position = np.array([moved.x, moved.y, moved.z])
            if link.parent != parent or not np.isfinite([*position, *quaternion]).all() or not quaternion.any():
                continue
            link.times_ns.append(build.ns_of(stamped.header.stamp))
            link.poses.append((position, quaternion))
    links = {child: link for child, link in links.items() if link.poses}
    for link in links.values():
        order = np.argsort(link.times_ns, kind="stable")
        link.times_ns = [link.times_ns[k] for k in order]
        link.poses = [link.poses[k] for k in order]
    return links


def _root(links: dict[str, Link], frame: str) -> str:
    for _ in range(LEVELS_MAX):
        frame = links[frame].parent if frame in links else frame
    return frame


def _placed(links: dict[str, Link], frame: str, fixed: str, time_ns: int) -> Floats | str:
    """Return the transform (4, 4) from a frame to the fixed one at a time, or why there is none."""
    matrix, at = np.eye(4), frame
    for _ in range(LEVELS_MAX):
        if at == fixed:
            return matrix
        if (link := links.get(at)) is None:
            return f"no transform leads from '{at}' to '{fixed}'"
        step = link.matrix(time_ns)
        if step is None:
            return f"the transforms of '{at}' do not reach its time"
        matrix, at = step @ matrix, link.parent
    return f"the transforms of '{frame}' form a circle"


def _cloud(message: Any) -> NDArray[np.float32] | None:
    """Return the finite points (n, 3) of a PointCloud2, None without coordinates as floats."""
    fields = {each.name: each for each in message.fields}
    if not all(axis in fields and fields[axis].datatype in FLOATS for axis in "xyz"):
        return None
    order = ">" if message.is_bigendian else "<"
    places = [(fields[axis].offset, order + FLOATS[fields[axis].datatype]) for axis in "xyz"]
    offsets, formats = zip(*places, strict=True)
    layout = np.dtype({"names": [*"xyz"], "offsets": offsets, "formats": formats, "itemsize": message.point_step})
    rows = np.frombuffer(bytes(message.data), np.uint8).reshape(message.height, -1)
    found = np.frombuffer(rows[:, : message.width * message.point_step].tobytes(), layout)
    points = np.column_stack([found[axis] for axis in "xyz"]).astype(np.float32)
    return points[np.isfinite(points).all(axis=1)]


def _scan(message: Any) -> NDArray[np.float32]:
    """Return the echoes (n, 3) of a LaserScan: ranges within its limits."""
    ranges = np.asarray(message.ranges, np.float64)
    angles = message.angle_min + np.arange(len(ranges)) * message.angle_increment
    hit = np.isfinite(ranges) & (ranges >= message.range_min) & (ranges <= message.range_max)
    x, y = ranges[hit] * np.cos(angles[hit]), ranges[hit] * np.sin(angles[hit])
    return np.column_stack([x, y, np.zeros_like(x)]).astype(np.float32)


POINTS_OF: dict[str, Callable[[Any], NDArray[np.float32] | None]] = {
    "sensor_msgs/msg/PointCloud2": _cloud,
    "sensor_msgs/msg/LaserScan": _scan,
}
"""Readers of points, by the type of message."""


def _matrix(position: Floats, quaternion: Floats) -> Floats:
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = Rotation.from_quat(quaternion).as_matrix(), position
    return matrix
