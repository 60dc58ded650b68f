"""The panel next to the fan: values, efforts as bars, warnings."""

from __future__ import annotations

import math

from rich.text import Text

from uwsim.base.axes import AXES
from uwsim.operator.teleop.readout import Readout

BAR = 10  # characters on each side of an effort's zero mark
LIT, DARK = "bold yellow", "dim"


def figures(readout: Readout) -> Text:
    """Return the values, two per line."""
    pairs = [
        ("speed", f"{_figure(readout.speed_m_s, 2)} m/s"), ("turn", f"{_figure(readout.turn_deg_s, 0)} °/s"),
        ("accel.", f"{_figure(math.hypot(*readout.acceleration_m_s2), 2)} m/s²"),
        ("turning", f"{_figure(math.hypot(*readout.angular_acceleration_deg_s2), 0)} °/s²"),
        ("depth", f"{_figure(readout.depth_m, 1)} m"), ("above bed", f"{_figure(readout.seabed_m, 1)} m"),
        ("station", f"{_figure(readout.station_m, 0)} m"), ("to port", f"{_figure(readout.port_m, 1)} m"),
        ("roll", f"{_figure(readout.roll_deg, 0)}°"), ("pitch", f"{_figure(readout.pitch_deg, 0)}°"),
        ("pressure", f"{_figure(readout.pressure_kpa, 0)} kPa"),
        ("water", f"{_figure(readout.temperature_deg_c, 1)} °C"),
        ("sonar", f"{_figure(readout.tilt_deg, 0)}°"), ("battery", f"{_figure(readout.battery_percent, 0)} %"),
        ("mission", _clock(readout.mission_s)), ("lamps", _lamps(readout)),
    ]  # fmt: skip
    text = Text(no_wrap=True)
    for k, (name, value) in enumerate(pairs):
        text.append(f"{name:<9}", "dim")
        text.append(f"{value:>9}" + ("   " if k % 2 == 0 else "\n"), "bold")
    east, north, up = readout.position_m
    text.append(f"{'at':<9}", "dim").append(f"{_figure(east, 1)}, {_figure(north, 1)}, {_figure(up, 1)} m", "bold")
    if readout.link:
        text.append(f"\n{'link':<9}", "dim").append(readout.link, "bold")
    return text


def effort_bars(asked: dict[str, float], obeyed: tuple[float, ...]) -> Text:
    """Return a bar for each axis, with the effort requested by the pilot and the effort reported by the vehicle."""
    text = Text(no_wrap=True)
    for k, axis in enumerate(AXES):
        effort = asked[axis]
        cells = round(abs(effort) * BAR)
        text.append(f"{axis:<6}", "bold" if effort else "dim")
        text.append(("█" * cells if effort < 0 else "").rjust(BAR), "red")
        text.append("┃", "white")
        text.append(("█" * cells if effort > 0 else "").ljust(BAR), "green")
        text.append(f"{obeyed[k]:+6.2f}\n" if len(obeyed) == len(AXES) else "\n", "dim")
    text.right_crop()
    return text


def _figure(value: float, digits: int) -> str:
    if math.isinf(value):
        return "beyond"
    return "---" if math.isnan(value) else f"{value:.{digits}f}"


def _clock(seconds: float) -> str:
    return f"{int(seconds) // 60}:{int(seconds) % 60:02d}" if math.isfinite(seconds) else "---"


def _lamps(readout: Readout) -> str:
    return " ".join("on" if on else "off" for on in readout.lamps) or "---"
