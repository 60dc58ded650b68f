"""Checks on values passed by callers."""

from __future__ import annotations

import math
import os
import re
import sys
from collections.abc import Mapping, Sequence
from typing import Any, TypeGuard

import numpy as np
from numpy.typing import NDArray

from uwsim.base.named import did_you_mean

UNITS = {"_m_s": "m/s", "_m": "m", "_s": "s", "_rad": "rad"}
Value = float | bool | str
NAME = re.compile(r"(?=.{1,200}$)[A-Za-z][A-Za-z0-9_]*(/[A-Za-z][A-Za-z0-9_]*)*", re.ASCII)
NAME_RULE = "must be letters, digits and _, beginning with a letter, between slashes, at most 200"  # ROS 2 allows 255


def number(value: Any, name: str, unit: str = "") -> float:
    """Convert a real number (Python's or NumPy's) to float. Raises ValueError for anything else, including booleans."""
    if not isinstance(value, bool | np.bool_ | str | bytes):
        try:
            return float(value)
        except (TypeError, ValueError, OverflowError):
            pass
    shown = f"{value!r:.60}"
    raise ValueError(f"{name} = {shown}: must be a number{f' [{unit}]' if unit else ''}")


def is_number(value: object) -> TypeGuard[float]:
    """Return whether a decoded value is a finite number. A boolean is none, nor a whole number beyond a float's range.

    `math.isfinite` and `float` raise OverflowError for such a whole number.
    """
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= sys.float_info.max


def is_within(value: object, low: float, high: float, *, whole: bool = False) -> TypeGuard[float]:
    """Return whether a decoded value is a number in [low, high], and a whole one if that is asked for."""
    return is_number(value) and low <= value <= high and (not whole or value % 1 == 0)


def require_positive(step: str = "", /, **values: float) -> None:
    """Raise ValueError unless all values are positive and finite. The name of each ends in its unit.

    step: the name of the function that received the values, to begin the message with.
    """
    for name, value in values.items():
        if not 0.0 < value < math.inf:
            unit = next((f" {unit}" for end, unit in UNITS.items() if name.endswith(end)), "")
            raise ValueError(f"{step and f'{step}: '}{name} = {value}{unit}: must be positive")


def plain(value: Any, path: str) -> Any:
    """Return a deep copy that contains only JSON types and bytes. Raises ValueError for other types."""
    if value is None or isinstance(value, bool | int | float | str | bytes):
        return value
    if isinstance(value, np.generic | np.ndarray):
        return plain(value.tolist(), path)
    if isinstance(value, Mapping):
        return {str(key): plain(item, f"{path}.{key}") for key, item in value.items()}
    if isinstance(value, Sequence):
        return [plain(item, f"{path}[{k}]") for k, item in enumerate(value)]
    raise ValueError(f"{path} is {type(value).__name__}: must be a number, text, a list or a dict")


def numbers_by_name(
    values: Mapping[str, float], what: str, known: list[str], unit: str = ""
) -> list[tuple[str, float]]:
    """Return (name, value) pairs. Raises ValueError for an unknown name or a value that is not a number."""
    if not isinstance(values, Mapping):
        raise ValueError(f"{what} = {values!r:.60}: must be numbers by name")
    for name in values:
        if name not in known:
            rule = f"must be one of {', '.join(known)}" if known else "the vehicle has none"
            raise ValueError(f"{what} = {name!r}: {rule}{did_you_mean(str(name), known)}")
    return [(name, number(value, f"{what}.{name}", unit)) for name, value in values.items()]


def checked_threads(threads: int | None) -> int:
    """Return the number of threads to use, by default one per core. Raises ValueError."""
    if threads is None:
        return len(os.sched_getaffinity(0))
    if isinstance(threads, bool) or not isinstance(threads, int | np.integer) or not 1 <= threads <= 1024:
        raise ValueError(f"threads = {threads!r}: must be a whole number in [1, 1024]")
    return int(threads)


def read_only(array: NDArray[np.float64]) -> NDArray[np.float64]:
    """Mark an array as read-only and return it, so that writing to this copy of the state raises an error."""
    array.setflags(write=False)
    return array


def checked_value(name: str, given: Any) -> Value:
    """Return a value that a topic can carry. name: the topic's. Raises ValueError."""
    if not NAME.fullmatch(name.removeprefix("/")):
        raise ValueError(f"log '{name:.80}': {NAME_RULE}")
    value = plain(given, f"log '{name}'")
    value = float(value) if isinstance(value, int | float) and not isinstance(value, bool) else value
    if not isinstance(value, Value) or (isinstance(value, float) and not math.isfinite(value)):
        raise ValueError(f"log '{name}' = {given!r:.60}: must be a finite number, a bool or a text")
    return value
