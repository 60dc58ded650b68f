"""Checks of the values that callers pass."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np


def number(value: Any, name: str, unit: str = "") -> float:
    """Return a real number, NumPy's included, as float. Raises ValueError for text, booleans and anything else."""
    if not isinstance(value, bool | np.bool_ | str | bytes):
        try:
            return float(value)
        except (TypeError, ValueError, OverflowError):
            pass
    shown = f"{value!r:.60}"
    raise ValueError(f"{name} = {shown}: must be a number{f' [{unit}]' if unit else ''}")


def plain(value: Any, path: str) -> Any:
    """Return a copy that nobody else can change, of JSON's types and bytes. Raises ValueError for other types."""
    if value is None or isinstance(value, bool | int | float | str | bytes):
        return value
    if isinstance(value, np.generic | np.ndarray):
        return plain(value.tolist(), path)
    if isinstance(value, Mapping):
        return {str(key): plain(item, f"{path}.{key}") for key, item in value.items()}
    if isinstance(value, Sequence):
        return [plain(item, f"{path}[{k}]") for k, item in enumerate(value)]
    raise ValueError(f"{path} is {type(value).__name__}: must be a number, text, a list or a dict")
