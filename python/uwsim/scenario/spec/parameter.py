"""Validates parameters of a kind of sensor or imaging sonar against the table in the kind's C++ file."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from uwsim.scenario.spec.fields import broken
from uwsim.scenario.spec.sensor_figure import SensorFigure


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
