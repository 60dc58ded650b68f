"""Writes a recording as MCAP in rosbag2 format: CDR, ros2msg schemas, type hashes, QoS, index and metadata.

The writer in `rosbags` cannot end a chunk before it is full, has neither checksums nor attachments, and creates a
folder. If the process were killed, up to a megabyte would be lost, which is minutes of a run with few messages.
"""

from __future__ import annotations

import contextlib
import fcntl
import functools
import json
import os
import re
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from mcap.data_stream import RecordBuilder
from mcap.records import Metadata
from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2.metadata import dump_qos_v9, parse_qos

from uwsim.base.own_files import mark
from uwsim.channels import Channel
from uwsim.channels.delivery.feed import Reading
from uwsim.channels.ros.cdr import schema
from uwsim.recording.mcap_file import RECORD_HEAD, McapFile
from uwsim.recording.sink import Batch

START, END, ROSBAG2 = "uwsim", "uwsim.end", "rosbag2"
"""Names of metadata records: the one written at the beginning, the one at the end, and rosbag2's own."""
VERSION = "1"
"""Version of the metadata and attachments. Incrementing it makes existing recordings unreadable."""
LIVE, SURVEY = "live", "survey"
"""Kinds of runs; in a survey, the pings contain everything that its sonar produced."""
PROFILE = "ros2"
LIBRARY = re.compile("uwsim, start ([0-9a-f]{8})")
"""The writer's name in the header, with the checksum of the metadata at the start, which is not otherwise protected if
the process is killed."""
ROSBAG2_VERSION = 9
FOREVER = QosTime(0x7FFFFFFF, 0xFFFFFFFF)  # rmw's value for an infinite duration
DEPTH = 10
QOS = "offered_qos_profiles"


class McapSink:
    """An MCAP file. Each flush ends a chunk, which is then safe even if the process is killed."""

    def __init__(self, path: Path, start: Mapping[str, str], attachments: Mapping[str, bytes]) -> None:
        """Create the file with metadata and attachments. Raises OSError if it exists or cannot be written."""
        self._path = path
        self._file = path.open("xb")
        mark(path, unfinished=True)
        with contextlib.suppress(OSError):  # a file system without locks
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)  # see is_being_written
        self._ids: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, Channel] = {}
        self._counts: dict[str, int] = {}
        self._first_ns, self._last_ns = 2**63 - 1, 0
        self._flushed = 0  # bytes
        try:
            self._writer = McapFile(self._file, PROFILE, f"uwsim, start {_checksum(START, start):08x}")
            self._writer.add_metadata(START, start)
            for name, content in attachments.items():
                self._writer.add_attachment(name, "application/octet-stream", content)
            self.flush()
        except BaseException:
            self._file.close()
            with contextlib.suppress(OSError):
                path.unlink()
            raise

    def encode(self, reading: Reading) -> memoryview:
        """Return a message as CDR bytes, which other sinks may share."""
        return reading.cdr

    def add_channel(self, channel: Channel) -> None:
        """Register a channel before its first message."""
        known = schema(channel.type)
        if channel.type not in self._schemas:
            self._schemas[channel.type] = self._writer.add_schema(known.name, "ros2msg", known.text.encode())
        topic, metadata = "/" + channel.name, metadata_of(channel)
        self._ids[channel.name] = self._writer.add_channel(topic, "cdr", self._schemas[channel.type], metadata)
        self._channels[channel.name] = channel
        self._counts[channel.name] = 0

    def write(self, messages: Batch) -> None:
        """Append messages at their simulated times. Raises OSError."""
        topics, which, times_ns, sequences, data = messages
        channels = np.array([self._ids[topic] for topic in topics])[which]
        self._writer.add_messages(channels, times_ns, sequences & 0xFFFFFFFF, data)
        for topic, count in zip(topics, np.bincount(which, minlength=len(topics)).tolist(), strict=True):
            self._counts[topic] += count
        self._first_ns = min(self._first_ns, int(times_ns.min()))
        self._last_ns = max(self._last_ns, int(times_ns.max()))

    def flush(self) -> None:
        """End the chunk and hand it to the operating system. Raises OSError."""
        self._writer.flush()
        self._flushed = self._file.tell()

    def close(self, end: Mapping[str, str]) -> None:
        """Write the metadata and index, and close the file. Raises OSError."""
        with self._file:
            self._writer.add_metadata(END, end)
            self._writer.add_metadata(ROSBAG2, {"serialized_metadata": json.dumps(self._rosbag2_metadata())})
            self._writer.finish()
            self._file.flush()
            os.fsync(self._file.fileno())
        mark(self._path)

    def abandon(self) -> None:
        """Close after a write error, truncating the file to its state at the last flush.

        Anything written since then has gaps. If data followed it, the file would be damaged instead of merely cut off.
        """
        kept = os.dup(self._file.fileno())
        with contextlib.suppress(OSError):
            self._file.close()
        with contextlib.suppress(OSError):
            os.ftruncate(kept, self._flushed)
        os.close(kept)

    def _rosbag2_metadata(self) -> dict[str, Any]:
        """Return the content of a bag folder's metadata.yaml, which `ros2 bag info` displays; JSON is YAML, too."""
        count = sum(self._counts.values())
        times = {
            "starting_time": {"nanoseconds_since_epoch": self._first_ns if count else 0},
            "duration": {"nanoseconds": self._last_ns - self._first_ns if count else 0},
            "message_count": count,
        }
        topics = [
            {
                "topic_metadata": {
                    "name": "/" + name,
                    "type": channel.type,
                    "serialization_format": "cdr",
                    "offered_qos_profiles": dump_qos_v9([qos(channel)]),
                    "type_description_hash": schema(channel.type).type_hash,
                },
                "message_count": self._counts[name],
            }
            for name, channel in self._channels.items()
        ]
        return {
            "version": ROSBAG2_VERSION,
            "storage_identifier": "mcap",
            "relative_file_paths": [self._path.name],
            **times,
            "topics_with_message_count": topics,
            "compression_format": "",
            "compression_mode": "",
            "files": [{"path": self._path.name, **times}],
            "custom_data": None,
            "ros_distro": "jazzy",
        }


def is_being_written(path: Path) -> bool:
    """Return whether a process, this one or another, is recording into a file. Raises OSError."""
    with path.open("rb") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
        except OSError:  # a file system without locks
            return False
    return False


def metadata_of(channel: Channel) -> dict[str, str]:
    """Return a channel's metadata for the file: the rosbag2 metadata, plus the channel's rate and description."""
    return {
        QOS: _qos_text(qos(channel)),
        "topic_type_hash": schema(channel.type).type_hash,
        "rate_hz": "" if channel.rate_hz is None else repr(channel.rate_hz),
        "description": channel.description,
    }


def qos(channel: Channel) -> Qos:
    """Return a channel's quality of service: reliable and, if latched, kept for late subscribers."""
    durability = QosDurability.TRANSIENT_LOCAL if channel.delivery.latched else QosDurability.VOLATILE
    return Qos(
        QosHistory.KEEP_LAST,
        1 if channel.delivery.latched else DEPTH,
        QosReliability.RELIABLE,
        durability,
        FOREVER,
        FOREVER,
        QosLiveliness.AUTOMATIC,
        FOREVER,
        False,
    )


def is_latched(metadata: Mapping[str, str]) -> bool:
    """Return whether a channel's metadata mark it as latched."""
    return any(profile.durability == QosDurability.TRANSIENT_LOCAL for profile in parse_qos(metadata[QOS]))


def _checksum(name: str, metadata: Mapping[str, str]) -> int:
    """Return the CRC-32 of a metadata record's content."""
    record = RecordBuilder()
    Metadata(name, dict(metadata)).write(record)
    return zlib.crc32(record.end()[RECORD_HEAD:])  # type: ignore[no-untyped-call]


@functools.cache  # a file's many channels have only two different profiles
def _qos_text(offered: Qos) -> str:
    return json.dumps(dump_qos_v9([offered]))
