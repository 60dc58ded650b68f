"""MotionLog: a vehicle's commands and motion, from a recording, an MCAP file, a ROS bag or a CSV table.

A mapping file states where each quantity is found: in a column of a table, or in a `topic:field` of a message log, such
as `/odom:pose.pose.position.x` or `/telemetry:efforts[0]`.
"""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, ValidationError
from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

from uwsim.base.axes import AXES
from uwsim.base.extras import need_extra
from uwsim.base.short_repr import ShortRepr
from uwsim.scenario.spec.fields import Model

Array = NDArray[np.float64]
ODOMETRY = {
    "position_m": [f"{{}}:pose.pose.position.{axis}" for axis in "xyz"],
    "orientation_xyzw": [f"{{}}:pose.pose.orientation.{axis}" for axis in "xyzw"],
    "velocity_body": [f"{{}}:twist.twist.{part}.{axis}" for part in ("linear", "angular") for axis in "xyz"],
}
LEAST_ROWS = 20
COMMANDS = "/uwsim/commands"
WITHOUT_MOTION = ("release", "set_lamp", "aim_camera")
"""Recorded commands that do not steer a vehicle, so that the efforts alone do."""


class Mapping(Model):
    """The location of each quantity in a log. World: z up; body: x forward, y left, z up (REP 103).

    time_s: a table's time column [s]. position_m (3), orientation_xyzw (4), velocity_body (6) [m/s, rad/s]:
    measured motion; positions and velocities may be left out. effort (6): commands in [-1, 1], surge to yaw, each held
    until the next one; null for an axis without commands. noise: standard deviations of position [m], attitude [rad],
    velocity [m/s] and rate [rad/s], if known; otherwise estimated from the residuals.
    """

    time_s: str | None = None
    position_m: tuple[str, str, str] | None = None
    orientation_xyzw: tuple[str, str, str, str]
    velocity_body: tuple[str, str, str, str, str, str] | None = None
    effort: tuple[str | None, str | None, str | None, str | None, str | None, str | None]
    noise: dict[str, float] = Field(default_factory=dict)


@dataclass(frozen=True, eq=False, repr=False)
class MotionLog(ShortRepr):
    """A vehicle's commands and motion.

    times_s (n,), increasing; position_m (n, 3), orientation_xyzw (n, 4), velocity_body (n, 6): NaN where not
    measured; effort_times_s (m,), efforts (m, 6): each held until the next. noise: see Mapping.
    """

    times_s: Array
    position_m: Array
    orientation_xyzw: Array
    velocity_body: Array
    effort_times_s: Array
    efforts: Array
    noise: dict[str, float]

    def efforts_at(self, times_s: Array) -> Array:
        """Return the efforts (n, 6) in effect just after these times; 0 before the first."""
        index = np.searchsorted(self.effort_times_s, times_s + 1e-6, side="right") - 1
        return np.where((index >= 0)[:, None], self.efforts[np.maximum(index, 0)], 0.0)


def read_mapping(path: Path) -> Mapping:
    """Read a mapping file. Raises ValueError, OSError."""
    try:
        content = YAML(typ="safe", pure=True).load(path.read_text(encoding="utf-8"))
    except (YAMLError, UnicodeDecodeError) as error:
        raise ValueError(f"{path}: not a YAML file: {str(error).splitlines()[0]}") from None
    try:
        return Mapping.model_validate(content)
    except ValidationError as error:
        first = error.errors()[0]
        raise ValueError(f"{path}: {'.'.join(map(str, first['loc'])) or 'mapping'}: {first['msg']}") from None


def read_log(path: str | Path, mapping: Mapping | None = None, vehicle: str = "") -> MotionLog:
    """Read a log. mapping: required unless the file is a uwsim recording. vehicle: prefix of its topics.

    Raises OSError, and ValueError with the file and the quantity.
    """
    path = Path(path)
    if path.suffix == ".csv":
        if mapping is None or mapping.time_s is None:
            raise ValueError(f"{path}: a table needs a mapping file (--map) with time_s")
        return _checked(path, _from_series(mapping, _table(path, mapping)))
    columns = _Messages(path)
    if mapping is None:
        mapping = columns.own_mapping(vehicle)
    return _checked(path, _from_series(mapping, columns.series))


Series = Callable[[str], tuple[Array, Array]]


def _from_series(mapping: Mapping, series: Series) -> MotionLog:
    times_s, _ = series(mapping.orientation_xyzw[0])

    def columns(names: tuple[str | None, ...] | None, width: int, at: Array, *, held: bool = False) -> Array:
        if names is None:
            return np.full((len(at), width), np.nan)
        found = np.zeros((len(at), width))
        for k, name in enumerate(names):
            if name is not None:
                own_times, values = series(name)
                if len(own_times) == len(at) and np.array_equal(own_times, at):
                    found[:, k] = values
                elif held:
                    index = np.maximum(np.searchsorted(own_times, at + 1e-6, side="right") - 1, 0)
                    found[:, k] = values[index]
                else:
                    found[:, k] = np.interp(at, own_times, values, np.nan, np.nan)
        return found

    given = next((name for name in mapping.effort if name is not None), None)
    if given is None:
        raise ValueError("effort: no axis has commands")
    effort_times_s, _ = series(given)
    return MotionLog(
        times_s,
        columns(mapping.position_m, 3, times_s),
        columns(mapping.orientation_xyzw, 4, times_s),
        columns(mapping.velocity_body, 6, times_s),
        effort_times_s,
        columns(mapping.effort, 6, effort_times_s, held=True),
        dict(mapping.noise),
    )


def _table(path: Path, mapping: Mapping) -> Series:
    with path.open(newline="", encoding="utf-8") as file:
        reader = csv.DictReader(file)
        rows = list(reader)
        names = reader.fieldnames or []

    def column(name: str) -> Array:
        if name not in names:
            raise ValueError(f"{path}: no column '{name}'; there are: {', '.join(names)}")
        try:
            return np.array([float(row[name] or "nan") for row in rows])
        except (TypeError, ValueError):
            raise ValueError(f"{path}: column '{name}': must be numbers") from None

    times_s = column(mapping.time_s or "")
    return lambda name: (times_s, column(name))


class _Messages:
    """The messages of a log by topic, decoded once."""

    def __init__(self, path: Path) -> None:
        need_extra("rosbags", "ros", f"{path}: a log of messages")
        if not path.exists():
            raise FileNotFoundError(2, "No such file or directory", str(path))
        self._path = path
        self._cache: dict[str, tuple[Array, list[Any]]] = {}
        self.topics = {topic for topic, _, _ in self._read(None)}

    def own_mapping(self, vehicle: str) -> Mapping:
        """Return the mapping for a uwsim recording: true or estimated odometry, and the efforts from the telemetry."""
        prefix = f"/{vehicle}" if f"/{vehicle}/telemetry" in self.topics else ""
        odometry = next((t for t in (f"{prefix}/ground_truth/odom", f"{prefix}/odom") if t in self.topics), None)
        if odometry is None or f"{prefix}/telemetry" not in self.topics:
            raise ValueError(
                f"{self._path}: no {prefix}/odom and {prefix}/telemetry: name the topics in a mapping file"
            )
        fields = {key: [name.format(odometry) for name in names] for key, names in ODOMETRY.items()}
        source = COMMANDS if self._keep_efforts(vehicle) else f"{prefix}/telemetry"
        return Mapping.model_validate({**fields, "effort": [f"{source}:efforts[{k}]" for k in range(6)]})

    def _keep_efforts(self, vehicle: str) -> bool:
        """Cache the recorded effort commands and their exact times; return whether they alone steered the vehicle."""
        if COMMANDS not in self.topics:
            return False
        times_s, rows = [], []
        for _, time_s, message in self._read(COMMANDS):
            command = json.loads(message.data)
            given = command["arguments"]
            if vehicle and given.get("vehicle", vehicle) != vehicle:
                continue
            if command["name"] == "set_effort":
                times_s.append(time_s)
                rows.append(SimpleNamespace(efforts=[given.get(axis, 0.0) for axis in AXES]))
            elif command["name"] not in WITHOUT_MOTION:
                return False
        self._cache[COMMANDS] = np.array(times_s), list(rows)
        return bool(rows)

    def series(self, name: str) -> tuple[Array, Array]:
        """Return times [s] and values of `topic:field`."""
        topic, colon, field = name.partition(":")
        if not colon or topic not in self.topics:
            raise ValueError(
                f"{self._path}: '{name}': must be topic:field, with a topic of {', '.join(sorted(self.topics))}"
            )
        if topic not in self._cache:
            rows = [(time, message) for _, time, message in self._read(topic)]
            self._cache[topic] = np.array([row[0] for row in rows]), [row[1] for row in rows]
        times_s, messages = self._cache[topic]
        parts = re.findall(r"[A-Za-z_]\w*|\[\d+\]", field)
        try:
            values = [_field(message, parts) for message in messages]
            return times_s, np.array(values, np.float64)
        except (AttributeError, IndexError, TypeError, ValueError):
            raise ValueError(f"{self._path}: '{name}': {topic} has no number there") from None

    def _read(self, topic: str | None) -> Iterator[tuple[str, float, Any]]:
        """Yield topic, time [s] and message. For None, yield all topics without their messages."""
        if self._path.suffix == ".mcap":
            yield from self._read_mcap(topic)
            return
        from rosbags.highlevel import AnyReader, AnyReaderError
        from rosbags.typesys import Stores, get_typestore

        try:
            with AnyReader([self._path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
                if topic is None:
                    yield from ((connection.topic, 0.0, None) for connection in reader.connections)
                    return
                wanted = [connection for connection in reader.connections if connection.topic == topic]
                for connection, time_ns, data in reader.messages(wanted):
                    yield topic, 1e-9 * time_ns, reader.deserialize(data, connection.msgtype)
        except AnyReaderError as error:
            raise ValueError(f"{self._path}: neither .csv, .mcap nor a ROS bag: {error}") from None

    def _read_mcap(self, topic: str | None) -> Iterator[tuple[str, float, Any]]:
        need_extra("mcap", "recording", f"{self._path}: an MCAP file")
        from mcap.exceptions import McapError
        from mcap.reader import make_reader
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore

        store = get_typestore(Stores.ROS2_HUMBLE)
        try:
            with self._path.open("rb") as file:
                reader = make_reader(file)
                if topic is None:
                    summary = reader.get_summary()
                    if summary is None:
                        raise ValueError(f"{self._path}: has no summary: the file was not closed")
                    yield from ((channel.topic, 0.0, None) for channel in summary.channels.values())
                    return
                for schema, _, message in reader.iter_messages(topics=[topic]):
                    if schema is None or schema.encoding != "ros2msg":
                        raise ValueError(f"{self._path}: '{topic}': must be ROS 2 messages")
                    if schema.name not in store.types:
                        store.register(get_types_from_msg(schema.data.decode(), schema.name))
                    yield topic, 1e-9 * message.log_time, store.deserialize_cdr(message.data, schema.name)
        except McapError as error:
            raise ValueError(f"{self._path}: not an MCAP file: {error}") from None


def _field(message: Any, parts: list[str]) -> float:
    for part in parts:
        message = message[int(part[1:-1])] if part.startswith("[") else getattr(message, part)
    return float(message)


def _checked(path: Path, log: MotionLog) -> MotionLog:
    """Return the log without rows that lack an attitude. Raises ValueError."""
    norms = np.linalg.norm(log.orientation_xyzw, axis=1)
    kept = np.isfinite(log.times_s) & (norms > 0.5)
    if kept.sum() < LEAST_ROWS:
        raise ValueError(f"{path}: {kept.sum()} rows with an attitude: at least {LEAST_ROWS} are needed")
    times_s = log.times_s[kept]
    if not (np.diff(times_s) > 0).all():
        at = int(np.argmax(~(np.diff(times_s) > 0)))
        raise ValueError(f"{path}: time {times_s[at]:g} s is followed by {times_s[at + 1]:g} s: times must increase")
    if not np.isfinite(log.efforts).all() or np.abs(log.efforts).max() > 1:
        worst = float(log.efforts.ravel()[np.argmax(np.abs(np.nan_to_num(log.efforts, nan=np.inf)))])
        raise ValueError(f"{path}: effort = {worst:g}: must be in [-1, 1]")
    quaternions = log.orientation_xyzw[kept] / norms[kept, None]
    return MotionLog(
        times_s, log.position_m[kept], quaternions, log.velocity_body[kept], log.effort_times_s, log.efforts, log.noise
    )
