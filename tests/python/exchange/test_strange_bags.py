"""Files of messages that ask for much: refused in one line, within the memory and time of a contained process."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from rosbags.rosbag1 import Writer
from rosbags.typesys import Stores, get_typestore

from uwsim.exchange.logs.motion_log import Mapping, read_log
from uwsim.recording.foreign_bag import map_from_bag
from uwsim.recording.real_flights.read import read_flight
from uwsim.scenario.read import contained

MAPPING = Mapping(orientation_xyzw=("/a:x", "/a:x", "/a:x", "/a:x"), effort=("/a:x", None, None, None, None, None))
READS: dict[str, Callable[[Path], Any]] = {
    "sensor_msgs/msg/PointCloud2": lambda path: map_from_bag(path, topic=None, frame=None, voxel_m=0.2),
    "nav_msgs/msg/Odometry": read_flight,
    "std_msgs/msg/String": lambda path: read_log(path, MAPPING),
}


def bag(path: Path, name: str, words: str, data: bytes) -> Path:
    """Write a bag of ROS 1 with a message of a type, which the bag defines by other words."""
    writer = Writer(path)
    writer.set_compression(Writer.CompressionFormat.BZ2)
    with writer:
        connection = writer.add_connection("/a", name, typestore=get_typestore(Stores.ROS1_NOETIC), msgdef=words)
        writer.write(connection, 0, data)
    return path


@pytest.mark.parametrize("name", READS)
def test_a_definition_or_a_chunk_that_asks_for_much_is_refused(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for words in ("string[2000000] a", "float64[1000000000] a", "uint8[] a\nstring[2000000] b"):
        path = bag(tmp_path / f"{len(words)}.bag", name, words, bytes(64))
        with pytest.raises(ValueError, match=r"takes more than|had not read it|bag") as refused:
            READS[name](path)
        assert "\n" not in str(refused.value) and path.stat().st_size < 10_000
    monkeypatch.setattr(contained, "MEMORY_BYTES", 100_000_000)
    path = bag(tmp_path / "bomb.bag", name, "uint8[] a", bytes(150_000_000))
    assert path.stat().st_size < 10_000
    with pytest.raises(ValueError, match=r"takes more than 0\.1 GB"):
        READS[name](path)


def test_a_bag_with_a_fifo_is_refused(tmp_path: Path) -> None:
    (tmp_path / "metadata.yaml").write_text("a: 1")
    os.mkfifo(tmp_path / "a.db3")
    with pytest.raises(OSError, match="is no regular file"):
        map_from_bag(tmp_path, topic=None, frame=None, voxel_m=0.2)
