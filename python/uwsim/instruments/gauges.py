"""The table of gauges: each number on a vehicle's panel is one entry.

An entry makes the field of /telemetry, the packings for modems, the row on the operator's panel, and the values in
its pictures. A sensor that a package registers needs no entry: its `numbers` are shown.
"""

from __future__ import annotations

import math
from typing import NamedTuple

LISTS = ("motion", "big", "around", "water", "")
"""The lists on the operator's panel, in their order; "" is not in any list."""


class Gauge(NamedTuple):
    """A number, or three along the body's axes. Entries are in the order of the message's fields.

    name: the field of /telemetry. note: follows the unit in the message's definition. packed: the quantum over a
    modem and its struct format code. slow: the same over a modem with small packets, after its place there; None if it
    is left out. missing: the value that a modem's missing one becomes. called: the name for people, a key of the page's
    words, if it is not `name`. sensor: the kind that measures it.
    """

    name: str
    unit: str
    shown_in: str
    packed: tuple[float, str]
    note: str = ""
    slow: tuple[int, float, str] | None = None
    missing: float = math.nan
    called: str = ""
    sensor: str = ""
    width: int = 1

    @property
    def word(self) -> str:
        """The name for people."""
        return self.called or self.name

    @property
    def attribute(self) -> str:
        """The name with the unit, as in the core's panel and in readings."""
        return f"{self.name}_{_suffix(self.unit)}"

    @property
    def column(self) -> str:
        """The name for people with the unit, as in files, and with % for the axis of three numbers."""
        return f"{self.word}{'_%' if self.width > 1 else ''}_{_suffix(self.unit)}"

    @property
    def definition(self) -> str:
        """The line of the message's definition."""
        kind = "float32" if self.width == 1 else f"float32[{self.width}]"
        return f"{f'{kind} {self.name}':<30} # {self.unit}{self.note}\n"


def _suffix(unit: str) -> str:
    return unit.replace("/", "_").replace(" ", "_").lower()


GAUGES = (
    Gauge("speed", "m/s", "motion", (0.01, "H"), slow=(1, 0.02, "B")),
    Gauge("angular_speed", "rad/s", "motion", (0.001, "H")),
    Gauge("temperature", "deg C", "water", (0.01, "h"), slow=(4, 0.5, "b"), sensor="temperature"),
    Gauge("pressure", "Pa", "water", (10.0, "I"), ", absolute", sensor="pressure"),
    Gauge("depth", "m", "big", (0.01, "i"), slow=(0, 0.01, "H"), sensor="depth"),
    Gauge("distance_to_station", "m", "around", (0.1, "H"), called="to_station"),
    Gauge(
        "distance_to_seabed", "m", "big", (0.1, "H"), ", straight down; inf: no echo", slow=(2, 0.1, "H"),
        missing=math.inf, called="altitude", sensor="altitude",
    ),
    Gauge(
        "distance_to_port", "m", "around", (0.1, "H"), ", of the proximity sensor; nan without one",
        slow=(3, 0.1, "B"), called="to_port", sensor="proximity",
    ),
    Gauge("mission_time", "s", "", (0.1, "I"), " since the release", slow=(5, 1.0, "H")),
    Gauge("battery", "percent", "", (0.5, "B"), slow=(6, 0.5, "B")),
    Gauge("link_delay", "s", "water", (0.001, "H"), ", one way, of sound between vehicle and station"),
    Gauge(
        "tilt", "rad", "", (0.001, "h"), ", of the sonar's head; up is positive; nan without one",
        slow=(7, 0.0125, "b"),
    ),
    Gauge(
        "linear_acceleration", "m/s2", "motion", (0.001, "h"), ", along the body's axes, without gravity",
        called="acceleration", sensor="acceleration", width=3,
    ),
    Gauge("angular_acceleration", "rad/s2", "motion", (0.001, "h"), ", about them", sensor="acceleration", width=3),
)  # fmt: skip
NUMBERS = tuple(gauge for gauge in GAUGES if gauge.width == 1)
VECTORS = tuple(gauge for gauge in GAUGES if gauge.width > 1)
SHOWN = sorted(GAUGES, key=lambda gauge: LISTS.index(gauge.shown_in))
"""The gauges in the order of the page."""
