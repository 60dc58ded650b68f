"""Finds the fields that differ between two messages of the same type, and the size of the differences."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from uwsim.channels.ros.message_types import fields
from uwsim.channels.ros.messages import from_bytes

SHOWN = 50  # number of characters of long text that are shown


def differences(kind: str, first: bytes, second: bytes) -> str:
    """Return the first two fields that differ, and by how much, on one line."""
    found = list(_fields(kind, from_bytes(first, kind), from_bytes(second, kind), ""))
    if not found:
        return "bytes that belong to no field"
    more = f", and {len(found) - 2} more fields" if len(found) > 2 else ""
    return ", ".join(found[:2]) + more


def largest(kind: str, first: bytes, second: bytes) -> float:
    """Return the largest finite difference between numbers in two messages, or NaN if there is none.

    Only floating-point numbers are compared, since differences in pictures, counts and text have no magnitude.
    """
    gaps = [gap for gap in _gaps(kind, from_bytes(first, kind), from_bytes(second, kind)) if 0.0 < gap < np.inf]
    return max(gaps, default=np.nan)


def _parts(kind: str, first: Any, second: Any, path: str) -> Iterator[tuple[str, Any, Any]]:
    """Yield the path and both values of every field that is not itself a message."""
    for field in fields(kind, 2):
        if field.attribute is None:
            continue
        a, b = getattr(first, field.attribute), getattr(second, field.attribute)
        name = f"{path}{field.name}"
        if not field.kind.is_message:
            yield name, a, b
        elif field.kind.length is None:
            yield from _parts(field.kind.base, a, b, f"{name}.")
        elif len(a) != len(b):
            yield f"{name}.length", len(a), len(b)
        else:
            for k, (one, other) in enumerate(zip(a, b, strict=True)):
                yield from _parts(field.kind.base, one, other, f"{name}[{k}].")


def _fields(kind: str, first: Any, second: Any, path: str) -> Iterator[str]:
    for name, a, b in _parts(kind, first, second, path):
        if isinstance(a, np.ndarray):
            if len(a) != len(b):
                yield f"{name}: {len(a)} and {len(b)} values"
            elif not np.array_equal(a, b, equal_nan=a.dtype.kind == "f"):
                unlike = np.flatnonzero((a != b) & ~(np.isnan(a) & np.isnan(b)) if a.dtype.kind == "f" else a != b)
                k = int(unlike[0])
                yield f"{name}[{k}]: {a[k]!s} and {b[k]!s} ({len(unlike)} of {len(a)} values differ)"
        elif a != b and not (_is_nan(a) and _is_nan(b)):
            at = next((k for k, (x, y) in enumerate(zip(a, b, strict=False)) if x != y), 0) if isinstance(a, str) else 0
            yield f"{name}: {_short(a, at)} and {_short(b, at)}"


def _gaps(kind: str, first: Any, second: Any) -> Iterator[float]:
    for _, a, b in _parts(kind, first, second, ""):
        if isinstance(a, np.ndarray) and a.dtype.kind == "f" and len(a) == len(b) and len(a):
            with np.errstate(invalid="ignore"):  # inf - inf
                gap = np.abs(np.asarray(a, np.float64) - np.asarray(b, np.float64))
            yield float(np.max(gap, where=np.isfinite(gap), initial=0.0))
        elif isinstance(a, float):
            yield abs(a - b)


def _is_nan(value: Any) -> bool:
    return isinstance(value, float) and value != value


def _short(value: Any, at: int) -> str:
    """Return a value as text. Long text is shortened to the part around a position."""
    if isinstance(value, str) and len(value) > SHOWN:
        start = max(at - SHOWN // 2, 0)
        value = ("..." if start else "") + value[start : start + SHOWN] + ("..." if start + SHOWN < len(value) else "")
    return repr(value)
