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
SECTORS = 9  # of the sonar's line


@dataclass
class Readout:
    """The latest values, or NaN if unknown. heading_deg: compass heading, clockwise from north.

    position_m: as reported by the server, in its odom frame. all_stop: None if unknown. link: modem, fraction of
    packets that arrive, delay, and time since the station last received from the vehicle. ranges_m: the last ping, from
    port to starboard.
    """

    position_m: tuple[float, ...] = (NAN, NAN, NAN)
    heading_deg: float = NAN
    depth_m: float = NAN
    altitude_m: float = NAN
    battery_percent: float = NAN
    mission_s: float = NAN
    efforts: tuple[float, ...] = ()
    all_stop: bool | None = None
    warnings: tuple[str, ...] = ()
    link: str = ""
    link_fault: str = ""
    ranges_m: NDArray[np.float32] = field(default_factory=lambda: np.empty(0, np.float32))
    model: int = MODEL

    def place(self, digits: int) -> str:
        """Return the position with a number of decimals."""
        return ", ".join(f"{value:.{digits}f}" for value in self.position_m) + " m"

    def sonar_line(self) -> str:
        """Return the nearest echo in each sector of the last ping."""
        if not len(self.ranges_m):
            return "---"
        nearest = [np.min(each, initial=math.inf) for each in np.array_split(self.ranges_m, SECTORS)]
        cells = " ".join(f"{echo_m:5.1f}" if math.isfinite(echo_m) else "    -" for echo_m in nearest)
        return f"port {cells} starboard"


Reader = Callable[[Readout, Any], None]


def read_telemetry(readout: Readout, message: Any) -> None:
    """Read a message of this project's /telemetry."""
    readout.position_m = tuple(map(float, message.true_position if message.is_truth else message.position))
    readout.heading_deg = _heading_deg(message.orientation)
    readout.depth_m, readout.altitude_m = message.depth, message.distance_to_seabed
    readout.battery_percent, readout.mission_s = message.battery, message.mission_time
    if len(message.efforts):  # absent from a slow modem's panel
        readout.efforts = tuple(map(float, message.efforts))
    readout.all_stop = ALL_STOPPED in message.alarms
    lit = {
        "FAR FROM STATION": message.range_warning,
        "NEAR THE SEABED": message.proximity_warning,
        "COLLISION": message.collision_warning,
        "DOCKED": not message.released,
        f"FAILSAFE: {message.failsafe} ({message.failsafe_cause}); z takes it back": message.failsafe,
    }
    alarms = (alarm for alarm in message.alarms if alarm != ALL_STOPPED)  # which has its own line
    readout.warnings = (*(name for name, is_on in lit.items() if is_on), *alarms)


def read_state_data(readout: Readout, message: Any) -> None:
    """Read the published panel: nine values, each followed by the letter a."""
    values = [float(text) for text in message.data.split("a") if text]
    if len(values) != 9:
        raise ValueError(f"stateData: {len(values)} values: must be 9")
    readout.depth_m, _, readout.altitude_m, readout.mission_s, readout.battery_percent = values[4:]


def read_pose(readout: Readout, message: Any) -> None:
    """Read the published propPos."""
    place, turned = message.position, message.orientation
    readout.position_m = (place.x, place.y, place.z)
    readout.heading_deg = _heading_deg((turned.x, turned.y, turned.z, turned.w))


def read_scan(readout: Readout, message: Any) -> None:
    """Read a LaserScan, whose angles are positive to port."""
    ranges_m = np.asarray(message.ranges, np.float32)
    readout.ranges_m = ranges_m[::-1] if message.angle_increment > 0.0 else ranges_m


def read_depths(readout: Readout, message: Any) -> None:
    """Read the published depthArray."""
    readout.ranges_m = np.asarray(ranging.decode_depth_string(message.data, readout.model), np.float32)[::-1]


def read_model(readout: Readout, message: Any) -> None:
    """Read the published modelTrigger."""
    if int(message.data) not in ranging.MODELS:
        raise ValueError(f"modelTrigger = {message.data!r:.20}: must be 1 to 4")
    readout.model = int(message.data)


def read_link(readout: Readout, message: Any) -> None:
    """Read this project's /link."""
    loss = message.fault_loss
    readout.link_fault = "LINK DOWN" if loss >= 1.0 else f"LINK LOSES {loss:.0%}" if loss else ""
    if message.modem != NO_LINK:
        delay = f" {1e3 * message.delay:.0f} ms" if math.isfinite(message.delay) else ""
        readout.link = f"{message.modem} {message.quality:.0%}{delay}, {message.silence_at_station:.0f} s ago"


TEXT = "std_msgs/msg/String"
LINK, NO_LINK = "uwsim_msgs/msg/Link", "none"
PANELS = (read_telemetry, read_state_data)
OWN_PANEL: dict[str, tuple[str, Reader]] = {"telemetry": ("uwsim_msgs/msg/Telemetry", read_telemetry)}
OWN_SONAR: dict[str, tuple[str, Reader]] = {"ping": ("sensor_msgs/msg/LaserScan", read_scan)}
PUBLISHED_PANEL: dict[str, tuple[str, Reader]] = {
    "stateData": (TEXT, read_state_data),
    "propPos": (POSE, read_pose),
}
PUBLISHED_SONAR: dict[str, tuple[str, Reader]] = {"modelTrigger": (TEXT, read_model), "depthArray": (TEXT, read_depths)}


def topics_to_read(offered: set[str], prefix: str) -> dict[str, tuple[str, Reader]]:
    """Return the type and handler of each useful topic. offered: the server's topics, or empty if they are unknown."""
    panel = OWN_PANEL if f"{prefix}telemetry" in offered else PUBLISHED_PANEL
    sonar = OWN_SONAR if f"{prefix}ping" in offered else PUBLISHED_SONAR
    link: dict[str, tuple[str, Reader]] = {"link": (LINK, read_link)} if f"{prefix}link" in offered else {}
    return {prefix + name: topic for name, topic in (panel | sonar | link).items()}


def _heading_deg(xyzw: Any) -> float:
    x, y, z, w = (float(value) for value in xyzw)
    if not 0.5 < x * x + y * y + z * z + w * w < 2.0:  # NaN, or not a rotation
        return NAN
    yaw_deg = float(Rotation.from_quat((x, y, z, w)).as_euler("ZYX", degrees=True)[0])
    return round(90.0 - yaw_deg) % 360
