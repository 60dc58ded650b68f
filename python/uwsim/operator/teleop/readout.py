"""The latest values from the vehicle's topics, as shown to the pilot."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from uwsim.channels.families.key import POSE
from uwsim.channels.ros.own_types import ALL_STOPPED
from uwsim.mapping import ranging

NAN = math.nan
MODEL = 2  # assumed sonar model until modelTrigger arrives
PUBLISHED_HFOV_DEG = 120.0  # assumed until hFOV arrives


@dataclass
class Readout:
    """The latest values, or NaN if unknown. heading_deg: compass heading, clockwise from north.

    position_m: as reported by the server, in its odom frame. link: modem, fraction of packets that arrive, delay, and
    time since the station last received from the vehicle; "" if there is no link.
    """

    position_m: tuple[float, float, float] = (NAN, NAN, NAN)
    heading_deg: float = NAN
    roll_deg: float = NAN
    pitch_deg: float = NAN
    speed_m_s: float = NAN
    turn_deg_s: float = NAN
    acceleration_m_s2: tuple[float, ...] = (NAN, NAN, NAN)
    angular_acceleration_deg_s2: tuple[float, ...] = (NAN, NAN, NAN)
    temperature_deg_c: float = NAN
    pressure_kpa: float = NAN
    depth_m: float = NAN
    station_m: float = NAN
    seabed_m: float = NAN
    port_m: float = NAN
    mission_s: float = NAN
    battery_percent: float = NAN
    tilt_deg: float = NAN
    efforts: tuple[float, ...] = ()
    lamps: tuple[bool, ...] = ()
    released: bool | None = None
    all_stop: bool = False
    warnings: tuple[str, ...] = ()
    link: str = ""
    link_fault: str = ""
    angles_rad: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    ranges_m: NDArray[np.float32] = field(default_factory=lambda: np.empty(0, np.float32))
    model: int = MODEL
    hfov_deg: float = PUBLISHED_HFOV_DEG


Reader = Callable[[Readout, Any], None]


def read_telemetry(readout: Readout, message: Any) -> None:
    """Read a message of this project's /telemetry."""
    place = message.true_position if message.is_truth else message.position
    readout.position_m = tuple(float(value) for value in place)  # type: ignore[assignment]
    _read_attitude(readout, message.orientation)
    readout.speed_m_s = message.speed
    readout.turn_deg_s = math.degrees(message.angular_speed)
    readout.acceleration_m_s2 = tuple(map(float, message.linear_acceleration))
    readout.angular_acceleration_deg_s2 = tuple(map(math.degrees, message.angular_acceleration))
    readout.temperature_deg_c = message.temperature
    readout.pressure_kpa = 1e-3 * message.pressure
    readout.depth_m = message.depth
    readout.station_m = message.distance_to_station
    readout.seabed_m = message.distance_to_seabed
    readout.port_m = message.distance_to_port
    readout.mission_s = message.mission_time
    readout.battery_percent = message.battery
    readout.tilt_deg = math.degrees(message.tilt)
    if len(message.efforts):  # absent from a slow modem's panel
        readout.efforts = tuple(float(value) for value in message.efforts)
    readout.lamps = tuple(bool(value) for value in message.lamps)
    readout.released = bool(message.released)
    readout.all_stop = ALL_STOPPED in message.alarms
    lit = {
        "FAR FROM STATION": message.range_warning,
        "NEAR THE SEABED": message.proximity_warning,
        "COLLISION": message.collision_warning,
    }
    alarms = ["ALL STOP: X releases it" if alarm == ALL_STOPPED else alarm for alarm in message.alarms]
    readout.warnings = (*(name for name, on in lit.items() if on), *alarms)
    if message.failsafe:
        readout.warnings += (f"FAILSAFE: {message.failsafe} ({message.failsafe_cause}); z takes it back",)


def read_state_data(readout: Readout, message: Any) -> None:
    """Read the published panel: nine values, each followed by the letter a."""
    values = [float(text) for text in message.data.split("a") if text]
    if len(values) != 9:
        raise ValueError(f"stateData: {len(values)} values: must be 9")
    (
        readout.speed_m_s, turn_rad_s, readout.temperature_deg_c, readout.pressure_kpa, readout.depth_m,
        readout.station_m, readout.seabed_m, readout.mission_s, readout.battery_percent,
    ) = values  # fmt: skip
    readout.turn_deg_s = math.degrees(turn_rad_s)


def read_pose(readout: Readout, message: Any) -> None:
    """Read the published propPos."""
    place, turned = message.position, message.orientation
    readout.position_m = (place.x, place.y, place.z)
    _read_attitude(readout, (turned.x, turned.y, turned.z, turned.w))


def read_scan_pose(readout: Readout, message: Any) -> None:
    """Read the published scanPos: a rotation about +y, positive nose down."""
    turned = message.orientation
    readout.tilt_deg = -math.degrees(2.0 * math.atan2(turned.y, turned.w))


def read_scan(readout: Readout, message: Any) -> None:
    """Read a LaserScan."""
    readout.ranges_m = np.asarray(message.ranges, np.float32)
    readout.angles_rad = message.angle_min + message.angle_increment * np.arange(len(readout.ranges_m))


def read_depths(readout: Readout, message: Any) -> None:
    """Read the published depthArray."""
    readout.ranges_m = np.asarray(ranging.decode_depth_string(message.data, readout.model), np.float32)
    half = math.radians(0.5 * readout.hfov_deg)
    readout.angles_rad = np.linspace(-half, half, len(readout.ranges_m))


def read_model(readout: Readout, message: Any) -> None:
    """Read the published modelTrigger."""
    if int(message.data) not in ranging.MODELS:
        raise ValueError(f"modelTrigger = {message.data!r:.20}: must be 1 to 4")
    readout.model = int(message.data)


def read_hfov(readout: Readout, message: Any) -> None:
    """Read the published hFOV."""
    readout.hfov_deg = float(message.data)


def read_proximity(readout: Readout, message: Any) -> None:
    """Read the published proximitySensor."""
    readout.port_m = float(message.data)


def read_link(readout: Readout, message: Any) -> None:
    """Read this project's /link."""
    is_down = message.fault_loss >= 1.0
    readout.link_fault = "LINK DOWN" if is_down else f"LINK LOSES {message.fault_loss:.0%}"
    if not message.fault_loss:
        readout.link_fault = ""
    if message.modem == NO_LINK:
        return
    delay = f" {1e3 * message.delay:.0f} ms" if math.isfinite(message.delay) else ""
    readout.link = f"{message.modem} {message.quality:.0%}{delay}, {message.silence_at_station:.0f} s ago"


TEXT = "std_msgs/msg/String"
LINK, NO_LINK = "uwsim_msgs/msg/Link", "none"
PANELS = (read_telemetry, read_state_data)
STANDARD: dict[str, tuple[str, Reader]] = {
    "telemetry": ("uwsim_msgs/msg/Telemetry", read_telemetry),
    "ping": ("sensor_msgs/msg/LaserScan", read_scan),
}
PUBLISHED: dict[str, tuple[str, Reader]] = {
    "stateData": (TEXT, read_state_data),
    "propPos": (POSE, read_pose),
    "scanPos": (POSE, read_scan_pose),
    "modelTrigger": (TEXT, read_model),
    "hFOV": (TEXT, read_hfov),
    "proximitySensor": (TEXT, read_proximity),
    "depthArray": (TEXT, read_depths),
}


def topics_to_read(offered: set[str], prefix: str) -> dict[str, tuple[str, Reader]]:
    """Return the type and handler of each useful topic. offered: the server's topics, or empty if they are unknown."""
    found: dict[str, tuple[str, Reader]] = {}
    panel, sonar = prefix + "telemetry" in offered, prefix + "ping" in offered
    for name, topic in (STANDARD | PUBLISHED).items():
        standard = name in STANDARD
        of_sonar = name in ("ping", "depthArray", "modelTrigger", "hFOV")
        if standard == (sonar if of_sonar else panel):
            found[prefix + name] = topic
    if prefix + "link" in offered:
        found[prefix + "link"] = (LINK, read_link)
    return found


def _read_attitude(readout: Readout, xyzw: Any) -> None:
    x, y, z, w = (float(value) for value in xyzw)
    if not 0.5 < x * x + y * y + z * z + w * w < 2.0:  # NaN, or not a rotation
        readout.heading_deg = readout.roll_deg = readout.pitch_deg = NAN
        return
    yaw_deg, pitch_deg, roll_deg = Rotation.from_quat((x, y, z, w)).as_euler("ZYX", degrees=True)
    readout.heading_deg = (90.0 - yaw_deg) % 360.0
    readout.roll_deg, readout.pitch_deg = roll_deg, pitch_deg
