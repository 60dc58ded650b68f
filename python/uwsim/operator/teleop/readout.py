"""The latest values from the vehicle's topics, as the pilot's line shows them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from scipy.spatial.transform import Rotation

from uwsim.channels.families.key import POSE
from uwsim.channels.ros.own_types import ALL_STOPPED

NAN = math.nan
NO_LINK = "none"


@dataclass
class Readout:
    """The latest values, or NaN if unknown. heading_deg: compass heading, clockwise from north.

    all_stop: None if unknown. link: modem, fraction of packets that arrive, delay, and time since the station last
    received from the vehicle.
    """

    heading_deg: float = NAN
    depth_m: float = NAN
    altitude_m: float = NAN
    battery_percent: float = NAN
    all_stop: bool | None = None
    warnings: tuple[str, ...] = ()
    link: str = ""
    link_fault: str = ""

    def numbers(self) -> str:
        """Return heading, depth, altitude and battery."""
        return (
            f"hdg {_figure(self.heading_deg)}°  depth {_figure(self.depth_m, 1)} m  "
            f"alt {_figure(self.altitude_m, 1)} m  bat {_figure(self.battery_percent)}%"
        )


Reader = Callable[[Readout, Any], None]


def read_telemetry(readout: Readout, message: Any) -> None:
    """Read a message of this project's /telemetry."""
    readout.heading_deg, readout.depth_m = _heading_deg(message.orientation), message.depth
    readout.altitude_m, readout.battery_percent = message.distance_to_seabed, message.battery
    readout.all_stop = ALL_STOPPED in message.alarms
    lit = {
        "FAR FROM STATION": message.range_warning,
        "NEAR THE SEABED": message.proximity_warning,
        "COLLISION": message.collision_warning,
        "DOCKED": not message.released,
        f"FAILSAFE: {message.failsafe} ({message.failsafe_cause}); z takes it back": message.failsafe,
    }
    alarms = (alarm for alarm in message.alarms if alarm != ALL_STOPPED)  # which begins the line
    readout.warnings = (*(name for name, is_on in lit.items() if is_on), *alarms)


def read_state_data(readout: Readout, message: Any) -> None:
    """Read the published panel: nine values, each followed by the letter a."""
    values = [float(text) for text in message.data.split("a") if text]
    if len(values) != 9:
        raise ValueError(f"stateData: {len(values)} values: must be 9")
    readout.depth_m, readout.altitude_m, readout.battery_percent = values[4], values[6], values[8]


def read_pose(readout: Readout, message: Any) -> None:
    """Read the published propPos."""
    turned = message.orientation
    readout.heading_deg = _heading_deg((turned.x, turned.y, turned.z, turned.w))


def read_link(readout: Readout, message: Any) -> None:
    """Read this project's /link."""
    loss = message.fault_loss
    readout.link_fault = "LINK DOWN" if loss >= 1.0 else f"LINK LOSES {loss:.0%}" if loss else ""
    if message.modem != NO_LINK:
        delay = f" {1e3 * message.delay:.0f} ms" if math.isfinite(message.delay) else ""
        readout.link = f"{message.modem} {message.quality:.0%}{delay}, {message.silence_at_station:.0f} s ago"


PANELS = (read_telemetry, read_state_data)
OWN: dict[str, tuple[str, Reader]] = {"telemetry": ("uwsim_msgs/msg/Telemetry", read_telemetry)}
LINK: dict[str, tuple[str, Reader]] = {"link": ("uwsim_msgs/msg/Link", read_link)}
PUBLISHED: dict[str, tuple[str, Reader]] = {
    "stateData": ("std_msgs/msg/String", read_state_data), "propPos": (POSE, read_pose),
}  # fmt: skip


def topics_to_read(offered: set[str], prefix: str) -> dict[str, tuple[str, Reader]]:
    """Return the type and handler of each useful topic. offered: the server's topics, or empty if they are unknown."""
    panel = OWN if f"{prefix}telemetry" in offered else PUBLISHED
    return {prefix + name: topic for name, topic in (panel | (LINK if f"{prefix}link" in offered else {})).items()}


def _figure(value: float, digits: int = 0) -> str:
    return ("beyond" if math.isinf(value) else "---" if math.isnan(value) else f"{value:.{digits}f}").rjust(3 + digits)


def _heading_deg(xyzw: Any) -> float:
    x, y, z, w = (float(value) for value in xyzw)
    if not 0.5 < x * x + y * y + z * z + w * w < 2.0:  # NaN, or not a rotation
        return NAN
    yaw_deg = float(Rotation.from_quat((x, y, z, w)).as_euler("ZYX", degrees=True)[0])
    return round(90.0 - yaw_deg) % 360
