"""Checks of the numbers that callers pass."""

from __future__ import annotations

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
