"""One-line descriptions of objects with arrays, which show each array's type and shape instead of its values."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import fields
from typing import Any

import numpy as np

LONGEST, SHOWN = 60, 4
"""The maximum length of a value's text, and the maximum size of an array whose values are shown."""


class ShortRepr:
    """A mixin for dataclasses with arrays, declared with repr=False."""

    def __repr__(self) -> str:
        return described(self, [field.name for field in fields(self) if field.repr])  # type: ignore[arg-type]


def described(thing: Any, names: Iterable[str]) -> str:
    """Return `Class(name=value, ...)` for these attributes."""
    values = ", ".join(f"{name}={_value(getattr(thing, name))}" for name in names)
    return f"{type(thing).__name__}({values})"


def _value(value: Any) -> str:
    if isinstance(value, np.ndarray):
        if value.size <= SHOWN and value.ndim == 1:
            return f"[{', '.join(_value(part) for part in value.tolist())}]"
        return f"{value.dtype} {value.shape}"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, Mapping) and len(value) > SHOWN:
        return f"{len(value)} items"
    if isinstance(value, list | tuple) and len(value) > SHOWN:
        return f"{len(value)} items"
    text = repr(value)
    return text if len(text) <= LONGEST else text[: LONGEST - 3] + "..."
