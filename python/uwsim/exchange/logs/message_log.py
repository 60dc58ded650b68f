"""The messages of a log, an MCAP file or a ROS bag, by topic."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.axes import AXES
from uwsim.base.extras import need_extra
from uwsim.recording.commands import command_of
from uwsim.recording.foreign_bag import opened_bag

Array = NDArray[np.float64]
COMMANDS = "/uwsim/commands"
WITHOUT_MOTION = ("release", "set_lamp", "aim_camera")
"""Recorded commands that do not steer a vehicle, so that the efforts alone do."""


class MessageLog:
    """The messages of a log by topic, decoded once."""

    def __init__(self, path: Path) -> None:
        need_extra("rosbags", f"{path}: a log of messages")
        if not path.exists():
            raise FileNotFoundError(2, "No such file or directory", str(path))
        self.path = path
        self._cache: dict[str, tuple[Array, list[Any]]] = {}
        self.commanded: set[str] = set()  # the vehicles that commands name, once they are read
        self.topics = {topic for topic, _, _ in self._read(None)}

    def keep_efforts(self, vehicle: str) -> bool:
        """Cache the recorded effort commands and their exact times; return whether they alone steered the vehicle."""
        if COMMANDS not in self.topics:
            return False
        times_s, rows = [], []
        for _, time_s, message in self._read(COMMANDS):
            try:
                command = command_of(message)
            except ValueError as error:
                raise ValueError(f"{self.path}: {error}") from None
            given = command.arguments
            self.commanded |= {str(given["vehicle"])} if "vehicle" in given else set()
            if vehicle and given.get("vehicle", vehicle) != vehicle:
                continue
            if command.name == "set_effort":
                times_s.append(time_s)
                rows.append(SimpleNamespace(efforts=[given.get(axis, 0.0) for axis in AXES]))
            elif command.name not in WITHOUT_MOTION:
                return False
        self._cache[COMMANDS] = np.array(times_s), list(rows)
        return bool(rows)

    def series(self, name: str) -> tuple[Array, Array]:
        """Return times [s] and values of `topic:field`."""
        topic, colon, field = name.partition(":")
        if not colon or topic not in self.topics:
            raise ValueError(
                f"{self.path}: '{name}': must be topic:field, with a topic of {', '.join(sorted(self.topics))}"
            )
        if topic not in self._cache:
            rows = [(time, message) for _, time, message in self._read(topic)]
            self._cache[topic] = np.array([row[0] for row in rows]), [row[1] for row in rows]
        times_s, messages = self._cache[topic]
        parts = re.findall(r"[A-Za-z_]\w*|\[\d+\]", field)
        try:
            values = np.array([_field(message, parts) for message in messages], np.float64)
        except (AttributeError, IndexError, TypeError, ValueError, OverflowError):
            raise ValueError(f"{self.path}: '{name}': {topic} has no number there") from None
        if np.isinf(values).any():
            at = int(np.argmax(np.isinf(values)))
            raise ValueError(f"{self.path}: '{name}' at {times_s[at]:.12g} s = {values[at]}: must be finite, or NaN")
        return times_s, values

    def _read(self, topic: str | None) -> Iterator[tuple[str, float, Any]]:
        """Yield topic, time [s] and message. For None, yield all topics without their messages. Raises ValueError."""
        try:
            yield from self._decoded(topic)
        except (OSError, ValueError, MemoryError):
            raise
        except Exception as error:  # the libraries raise errors of many types for a damaged file
            raise ValueError(f"{self.path}: is damaged: {type(error).__name__}: {error!s:.100}") from None

    def _decoded(self, topic: str | None) -> Iterator[tuple[str, float, Any]]:
        if self.path.suffix == ".mcap":
            yield from self._read_mcap(topic)
            return
        with opened_bag(self.path) as bag:
            if topic is None:
                yield from ((connection.topic, 0.0, None) for connection in bag.connections)
                return
            wanted = [connection for connection in bag.connections if connection.topic == topic]
            for connection, time_ns, data in bag.messages(wanted):
                yield topic, 1e-9 * time_ns, bag.deserialize(data, connection.msgtype)

    def _read_mcap(self, topic: str | None) -> Iterator[tuple[str, float, Any]]:
        need_extra("mcap", f"{self.path}: an MCAP file")
        from mcap.exceptions import McapError
        from mcap.reader import make_reader
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore

        store = get_typestore(Stores.ROS2_HUMBLE)
        try:
            with self.path.open("rb") as file:
                reader = make_reader(file)
                if topic is None:
                    summary = reader.get_summary()
                    if summary is None:
                        raise ValueError(f"{self.path}: has no summary: the file was not closed")
                    yield from ((channel.topic, 0.0, None) for channel in summary.channels.values())
                    return
                for schema, _, message in reader.iter_messages(topics=[topic]):
                    if schema is None or schema.encoding != "ros2msg":
                        raise ValueError(f"{self.path}: '{topic}': must be ROS 2 messages")
                    if schema.name not in store.types:
                        store.register(get_types_from_msg(schema.data.decode(), schema.name))
                    yield topic, 1e-9 * message.log_time, store.deserialize_cdr(message.data, schema.name)
        except McapError as error:
            raise ValueError(f"{self.path}: not an MCAP file: {error}") from None


def _field(message: Any, parts: list[str]) -> float:
    for part in parts:
        message = message[int(part[1:-1])] if part.startswith("[") else getattr(message, part)
    return float(message)
