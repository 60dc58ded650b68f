"""ROS bags of others with a vehicle's odometry and the commands of its thrusters, read by rosbags."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arrays import Floats
from uwsim.base.extras import need_extra
from uwsim.channels.ros import build
from uwsim.recording.foreign_bag import METADATA, foreign_bag, opened_bag
from uwsim.recording.real_flights.flight_log import MOST_ROWS, QUANTITIES, FlightLog, Series, series_of
from uwsim.scenario.read.contained import run_contained

KIND = "a ROS bag"
MAGICS = (b"#ROSBAG V2.0", b"SQLite format 3", b"\x89MCAP0")
AXES = ("x", "y", "z")
STANDARD_DENSITY, GRAVITY_M_S2, AIR_PA = 1000.0, 9.80665, 101325.0


class Read(NamedTuple):
    """How a quantity is read from a type of message, best type first. words: one must be in the topic's name."""

    quantity: str
    type: str
    numbers: Callable[[Any], list[float]]
    shown: str
    words: tuple[str, ...] = ()
    assumed: str = ""


def _xyz(vector: Any) -> list[float]:
    return [vector.x, vector.y, vector.z]


def _xyzw(quaternion: Any) -> list[float]:
    return [*_xyz(quaternion), quaternion.w]


def _depth_m(message: Any) -> list[float]:
    return [(message.fluid_pressure - AIR_PA) / (STANDARD_DENSITY * GRAVITY_M_S2)]


OF_IMU = "the IMU's axes are the body's, and its gyro has no bias"
OF_PRESSURE = f"{STANDARD_DENSITY:g} kg/m3 of water under {AIR_PA:g} Pa of air"
THRUSTERS = ("thruster", "motor", "propeller", "setpoint/pwm", "servo", "actuator")
READS = (
    Read("attitude", "nav_msgs/msg/Odometry", lambda m: _xyzw(m.pose.pose.orientation), "pose.pose.orientation"),
    Read("attitude", "geometry_msgs/msg/PoseStamped", lambda m: _xyzw(m.pose.orientation), "pose.orientation"),
    Read("attitude", "sensor_msgs/msg/Imu", lambda m: _xyzw(m.orientation), "orientation"),
    Read("position", "nav_msgs/msg/Odometry", lambda m: _xyz(m.pose.pose.position), "pose.pose.position [m]"),
    Read("position", "geometry_msgs/msg/PoseStamped", lambda m: _xyz(m.pose.position), "pose.position [m]"),
    Read("body velocity", "nav_msgs/msg/Odometry", lambda m: _xyz(m.twist.twist.linear), "twist.twist.linear [m/s]"),
    Read("rates", "nav_msgs/msg/Odometry", lambda m: _xyz(m.twist.twist.angular), "twist.twist.angular [rad/s]"),
    Read("rates", "sensor_msgs/msg/Imu", lambda m: _xyz(m.angular_velocity), "angular_velocity [rad/s]", (), OF_IMU),
    Read("depth", "sensor_msgs/msg/FluidPressure", _depth_m, "fluid_pressure [Pa]", (), OF_PRESSURE),
    Read("outputs", "mavros_msgs/msg/RCOut", lambda m: [float(v) for v in m.channels], "channels [us]"),
    *(
        Read("thrusters", f"std_msgs/msg/{kind}MultiArray", lambda m: [float(v) for v in m.data], "data", THRUSTERS)
        for kind in ("Float64", "Float32")
    ),
)


def is_bag(path: Path, head: bytes) -> bool:
    """Return whether a path is the folder of a bag, or one of its files."""
    return (path.is_dir() and (path / METADATA).is_file()) or head.startswith(MAGICS)


def read_bag(path: Path) -> FlightLog:
    """Read a bag. Raises OSError, or ValueError."""
    need_extra("rosbags", f"{path}: {KIND}")
    bag = foreign_bag(path)
    if bag is None:
        raise ValueError(f"{path}: a recording of uwsim: `uwsim replay` repeats it, `uwsim vehicle identify` reads it")
    made = run_contained(Path(__file__), "rosbags", str(bag), reads=[bag])
    sources, assumed = made.pop("sources"), made.pop("assumed")
    tables = zip(made.items(), sources.tolist(), strict=True)
    series = {name: Series(rows[:, 0], rows[:, 1:], source) for (name, rows), source in tables}
    return FlightLog(path, KIND, series, assumed=tuple(assumed.tolist()))


def read(path: str) -> dict[str, NDArray[Any]]:
    """Return a table of times and values by quantity, their sources, and what is assumed: a contained process's."""
    with opened_bag(Path(path)) as bag:
        log = _read(bag, Path(path))
    tables = {name: np.column_stack([each.times_s, each.values]) for name, each in log.series.items()}
    sources = [each.source for each in log.series.values()]
    return {**tables, "sources": np.array(sources, str), "assumed": np.array(log.assumed, str)}


def _read(bag: Any, path: Path) -> FlightLog:
    found: dict[str, Series] = {}
    assumed: list[str] = []
    tables: dict[tuple[str, str], Floats] = {}
    for each in READS:
        topic = _topic_of(bag, each)
        if each.quantity in found or topic is None:
            continue
        table = tables[topic, each.quantity] = _table(bag, path, topic, each)
        series = series_of(path, table[:, 0], table[:, 1:], f"{topic}: {each.shown}")
        if series is None:
            continue
        if each.quantity == "thrusters" and np.nanmax(np.abs(series.values), initial=0.0) > 1.0:
            assumed.append(f"{topic} holds no commands of thrusters: its numbers leave [-1, 1]")
            continue
        found[each.quantity] = series
        assumed += [f"{each.quantity}: {each.assumed}"] if each.assumed else []
    if not found:
        seen = ", ".join(sorted({f"{each.topic} ({each.msgtype})" for each in bag.connections}))
        wanted = ", ".join(dict.fromkeys(each.type for each in READS))
        raise ValueError(f"{path}: {KIND}: has none of {wanted}; has {seen or 'no topic'}")
    assumed.append("attitude and position are in axes east, north, up, of a body x forward, y left, z up (REP 103)")
    return FlightLog(path, KIND, {name: found[name] for name in QUANTITIES if name in found}, assumed=tuple(assumed))


def _topic_of(bag: Any, wanted: Read) -> str | None:
    """Return the topic of most messages of a type."""
    counts: Counter[str] = Counter()
    for each in bag.connections:
        if each.msgtype == wanted.type and (not wanted.words or any(w in each.topic.lower() for w in wanted.words)):
            counts[each.topic] += each.msgcount
    return counts.most_common(1)[0][0] if counts and counts.most_common(1)[0][1] else None


def _table(bag: Any, path: Path, topic: str, wanted: Read) -> Floats:
    """Return times [s] and numbers of a topic's messages, those as wide as the first."""
    rows: dict[int, list[list[float]]] = defaultdict(list)
    connections = [each for each in bag.connections if each.topic == topic]
    for connection, time_ns, data in bag.messages(connections):
        message = bag.deserialize(data, connection.msgtype)
        stamp = getattr(getattr(message, "header", None), "stamp", None)
        stamped = 0 if stamp is None else build.ns_of(stamp)
        row = [1e-9 * (stamped or time_ns), *map(float, wanted.numbers(message))]
        rows[len(row)].append(row)
        if len(rows[len(row)]) > MOST_ROWS:
            raise ValueError(f"{path}: more than {MOST_ROWS} messages on {topic}: cut the bag")
    return np.array(max(rows.values(), key=len, default=np.zeros((0, 2))), np.float64)
