"""The parameters of the bridge itself: names, defaults and limits as ArduSub's."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

BUTTON_FUNCTIONS = (0, 5, 7, 6, 4, 1, 3, 21, 48, 23, 22, 42, 43, 33, 32, 0)
"""BTN0_FUNCTION to BTN15_FUNCTION (AP_JSButton.h), as in ArduSub's default_js_buttons."""
FUNCTION_MAX = 250


class Setting(NamedTuple):
    """A parameter's value at the start, and its limits."""

    value: float
    low: float
    high: float


SETTINGS: Mapping[str, Setting] = {
    **{f"BTN{k}_FUNCTION": Setting(number, 0, FUNCTION_MAX) for k, number in enumerate(BUTTON_FUNCTIONS)},
    "JS_GAIN_DEFAULT": Setting(0.5, 0.1, 1.0),
    "JS_GAIN_MIN": Setting(0.25, 0.1, 0.8),
    "JS_GAIN_MAX": Setting(1.0, 0.2, 1.0),
    "JS_GAIN_STEPS": Setting(4, 1, 10),
    "JS_THR_GAIN": Setting(1.0, 0.5, 4.0),
    "FS_GCS_ENABLE": Setting(1, 0, 4),  # ArduSub's is 2; many scripts send only one heartbeat, as MAVLink permits
    "FS_GCS_TIMEOUT": Setting(5.0, 0.1, 3600.0),
    "FENCE_ENABLE": Setting(1, 0, 1),  # ArduSub's is 0; here a fence that was uploaded is meant
    "FENCE_ACTION": Setting(0, 0, 2),  # to report is all that ArduSub does, whatever the value (fence.cpp)
}


class Settings(Mapping[str, float]):
    """The present values, by name. Must be used on one thread."""

    def __init__(self) -> None:
        self._values = {name: setting.value for name, setting in SETTINGS.items()}

    def __getitem__(self, name: str) -> float:
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def set(self, name: str, value: float) -> None:
        """Set a value. Raises ValueError beyond its limits."""
        _, low, high = SETTINGS[name]
        if not low <= value <= high:
            raise ValueError(f"parameter '{name}' = {value:g}: must be in [{low:g}, {high:g}]")
        self._values[name] = value
