"""The latest values from the vehicle's topics, as the pilot's line shows them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from uwsim.base.quaternions import heading_rad
from uwsim.channels.ros.own_types import ALL_STOPPED

NO_LINK = "none"


@dataclass
class Readout:
    """The values of the latest messages, as texts. all_stop: None if unknown."""

    numbers: str = "no numbers yet"
    all_stop: bool | None = None
    warnings: tuple[str, ...] = ()
    link: str = ""
    link_fault: str = ""

    def read_telemetry(self, message: Any) -> None:
        """Read a message of /telemetry."""
        heading_deg = 90.0 - math.degrees(heading_rad(message.orientation))  # of a compass; NaN if unknown
        self.numbers = (
            f"hdg {_figure(round(heading_deg) % 360 if math.isfinite(heading_deg) else math.nan)}°  "
            f"depth {_figure(message.depth, 1)} m  alt {_figure(message.distance_to_seabed, 1)} m  "
            f"bat {_figure(message.battery)}%"
        )
        self.all_stop = ALL_STOPPED in message.alarms
        lit = {
            "FAR FROM STATION": message.range_warning,
            "NEAR THE SEABED": message.proximity_warning,
            "COLLISION": message.collision_warning,
            "DOCKED": not message.released,
            f"FAILSAFE: {message.failsafe} ({message.failsafe_cause}); z takes it back": message.failsafe,
        }
        alarms = (alarm for alarm in message.alarms if alarm != ALL_STOPPED)  # which begins the line
        self.warnings = (*(name for name, is_on in lit.items() if is_on), *alarms)

    def read_link(self, message: Any) -> None:
        """Read a message of /link: modem, packets that arrive, delay, time since the station last received any."""
        loss = message.fault_loss
        self.link_fault = "LINK DOWN" if loss >= 1.0 else f"LINK LOSES {loss:.0%}" if loss else ""
        if message.modem != NO_LINK:
            delay = f" {1e3 * message.delay:.0f} ms" if math.isfinite(message.delay) else ""
            self.link = f"{message.modem} {message.quality:.0%}{delay}, {message.silence_at_station:.0f} s ago"


def _figure(value: float, digits: int = 0) -> str:
    return ("beyond" if math.isinf(value) else "---" if math.isnan(value) else f"{value:.{digits}f}").rjust(3 + digits)
