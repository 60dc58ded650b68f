"""The table of kinds of sensors: those of the native core, and those that packages write in Python.

All are registered in the entry point group `uwsim.kinds.sensor`; docs/inside/extend.md adds one. The reader of
scenarios, the sensors, the parameters and the channels look kinds up here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any, Protocol

from uwsim import _core
from uwsim.base.sockets import load, load_all, registered
from uwsim.scenario.spec.fields import NAME, broken
from uwsim.scenario.spec.json_schema import SensorFigure

GROUP = "uwsim.kinds.sensor"
Widths = Mapping[str, tuple[int, str]]
"""The number of values and the unit of each quantity, by name."""


class SensorKind(Protocol):
    """A kind of sensor; see _core.SensorKind."""

    @property
    def name(self) -> str:
        """The kind."""

    @property
    def meaning(self) -> str:
        """The quantity that it measures."""

    @property
    def fields(self) -> Widths:
        """The quantities of a reading."""

    @property
    def channels(self) -> Widths:
        """The quantities to which noise is added."""

    @property
    def parameters(self) -> Mapping[str, SensorFigure]:
        """The keys of this kind."""


@dataclass(frozen=True)
class Figure:
    """A key of a kind of sensor in Python: one number in [low, high], or a default of NaN if it is required."""

    by_default: float
    low: float
    high: float
    unit: str
    meaning: str
    width: int = 1
    type: str = "number"


@dataclass(frozen=True)
class DerivedKind:
    """A kind of sensor in Python: it computes its quantities from what one of the core's kinds measures without errors.

    source: that kind, which is measured at the sensor's place, rate and latency. fields: the quantities of a reading,
    with their widths and units. measure(values, figures, time_s): returns them by name; `values` are the source's
    quantities, numbers or arrays (n,), `figures` the sensor's own keys, and time_s the time of the measurement. It must
    depend on nothing else, so that a sample is the same whenever and however often it is read. A sample with NaN is
    invalid. listens: whether measure is also given a function of a place (3,) and of the lowest and the highest
    frequency [Hz], which returns the pingers' last burst that has arrived there since the sample before, or None.
    parameters: its own keys. type, write(value, header, variance): the ROS message, by its name and as a dict of its
    fields, of a reading and the error variance of each quantity by name; without a type, the sensor has no
    channel.
    """

    name: str
    meaning: str
    source: str
    fields: Widths
    measure: Callable[..., Mapping[str, Any]]
    parameters: Mapping[str, Figure] = field(default_factory=dict)
    listens: bool = False
    type: str = ""
    write: Callable[[Any, Any, Mapping[str, float]], Mapping[str, Any]] | None = None

    def __post_init__(self) -> None:
        if self.source not in _core.sensor_kinds():
            raise ValueError(f"source = '{self.source}': must be one of {', '.join(_core.sensor_kinds())}")
        for key in (self.name, *self.fields, *self.parameters):
            if not NAME.fullmatch(key):
                raise ValueError(f"'{key}': must be a letter followed by at most 39 letters, digits, '-' or '_'")
        if not self.fields:
            raise ValueError("fields: must have at least one")
        for name, (_, unit) in self.fields.items():
            if not unit.isprintable():
                raise ValueError(f"unit {unit!r} of '{name}': must be printable")
        if bool(self.type) != (self.write is not None):
            raise ValueError("type and write: give both or none")

    @property
    def channels(self) -> Widths:
        """The quantities to which noise is added: all."""
        return self.fields


class _Core:
    """The core's kinds, as attributes."""

    def __getattr__(self, name: str) -> _core.SensorKind:
        if name not in _core.sensor_kinds():
            raise AttributeError(name)
        return _core.sensor_kind(name)


CORE = _Core()


def sensor_kinds() -> list[str]:
    """Return the names of all kinds, uwsim's own first."""
    return list(registered(GROUP))


def usable_sensor_kinds() -> list[SensorKind]:
    """Return all kinds, uwsim's own first. Warns with SocketWarning of those of broken packages."""
    return list(load_all(GROUP, _fitting).values())


@cache
def sensor_kind(name: str) -> SensorKind:
    """Return a kind. Raises ValueError for an unknown name, or one whose package is broken."""
    found: SensorKind = load(GROUP, name, _fitting)
    return found


def _fitting(name: str, kind: Any) -> SensorKind:
    if not isinstance(kind, DerivedKind | _core.SensorKind):
        raise TypeError(f"must be a {DerivedKind.__module__}.DerivedKind")
    if kind.name != name:
        raise TypeError(f"is named '{kind.name}'")
    return kind


def figures_of(kind: SensorKind, given: Mapping[str, tuple[float, ...]]) -> dict[str, float]:
    """Return the values of a kind's keys that have one value, those that are not given by default."""
    return {
        name: given[name][0] if name in given else figure.by_default
        for name, figure in kind.parameters.items()
        if figure.width == 1 and (name in given or not math.isnan(figure.by_default))
    }


def checked_values(key: str, value: Any, parameter: SensorFigure, *, in_degrees: bool = False) -> tuple[float, ...]:
    """Return a parameter's values, in degrees if in_degrees. If a rule is broken, raises the error at the key."""
    several = parameter.width > 1
    values = list(value) if several and isinstance(value, Sequence) and not isinstance(value, str) else [value]
    if several and len(values) != parameter.width:
        raise broken(f"must have {parameter.width} values", at=(key,), value=value)
    for number in values:
        _check_type(key, number, parameter)
        inside = math.radians(number) if in_degrees else number
        if not parameter.low <= inside <= parameter.high:
            unit = "deg" if in_degrees else parameter.unit
            rule = f"must be in {_interval(parameter, in_degrees)} {unit}".rstrip()
            raise broken(rule, at=(key,), value=float(number), unit=unit)
    return tuple(float(number) for number in values)


def _check_type(key: str, value: Any, parameter: SensorFigure) -> None:
    if parameter.type == "flag":
        if value not in (True, False):
            raise broken("must be true or false", at=(key,), value=value)
        return
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise broken("must be a number", at=(key,), value=value)
    if parameter.type == "whole number" and value != math.floor(value):
        raise broken("must be a whole number", at=(key,), value=value)


def _interval(parameter: SensorFigure, in_degrees: bool) -> str:
    low, high = parameter.low, parameter.high
    if in_degrees:
        low, high = math.degrees(low), math.degrees(high)
    least = "(0" if 0 < low < 1e-300 else f"[{low:g}"
    return f"{least}, {high:g}]"
