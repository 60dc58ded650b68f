"""Names and values of commands and events in words: {"for_s": 5.0} is `for 5 s`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

UNITS = {
    "_m_s2": "m/s2", "_rad_s": "deg/s", "_m_s": "m/s", "_deg_c": "deg C", "_kg_per_s": "kg/s", "_kg_max": "kg",
    "_kg": "kg", "_nm": "N m", "_rad": "deg", "_deg": "deg", "_hz": "Hz", "_lm": "lm", "_m": "m", "_s": "s", "_n": "N",
}  # fmt: skip
"""Units by the ends of names, longer ends first; angles in radians are given in degrees."""
FRAMES = ("_world", "_body")


class Detail(NamedTuple):
    """A value in words. name: without its unit, "" if the text alone is enough. text: the value, with its unit."""

    name: str
    text: str

    def __str__(self) -> str:
        """Both."""
        return f"{self.name} {self.text}".strip()


def words(name: str) -> str:
    """Return a name of Python in words."""
    return name.replace("_", " ")


def details(values: Mapping[str, Any], last: Mapping[str, Any] | None = None) -> list[Detail]:
    """Return values in words, without empty ones and bytes. last: values that differ then are `first to last`."""
    found = []
    for key, value in values.items():
        end = value if last is None else last[key]
        if value is None or isinstance(value, bytes) or value in ("", {}, [], ()):
            continue
        if key == "name" and value == values.get("kind"):
            continue  # a fault is named after its kind unless it has a name of its own
        name, unit, scale = _unit(key)
        first, text = _text(value, scale), _text(end, scale)
        text = text if first == text else f"{first} to {text}"
        found.append(Detail("" if isinstance(value, bool) and key == "on" else words(name), f"{text} {unit}".strip()))
    return found


def with_details(head: str, given: Sequence[Detail]) -> str:
    """Return a head, and what it is given."""
    return head + (f": {', '.join(map(str, given))}" if given else "")


def _unit(key: str) -> tuple[str, str, float]:
    """Return a name without unit and frame, the unit, and the factor by which values are multiplied."""
    end = next((each for each in UNITS if key.endswith(each)), "")
    name = key.removesuffix(end)
    for frame in FRAMES:
        name = name.removesuffix(frame)
    return name or key, UNITS.get(end, ""), math.degrees(1.0) if "_rad" in end else 1.0


def _text(value: Any, scale: float) -> str:
    if isinstance(value, bool):
        return "on" if value else "off"
    if isinstance(value, float) or (isinstance(value, int) and scale != 1.0):
        return f"{scale * value:.3g}"
    if isinstance(value, Mapping):
        return ", ".join(map(str, details(value)))
    if isinstance(value, list | tuple):
        return f"({', '.join(_text(each, scale) for each in value)})"
    return str(value)
