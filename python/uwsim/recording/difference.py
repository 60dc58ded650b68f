"""How two messages of one type differ: the fields, by name, and by how much."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from uwsim.channels.message_types import fields
from uwsim.channels.messages import from_bytes


def differences(kind: str, first: bytes, second: bytes) -> str:
    """Return the first fields that differ and by how much, as one line; two fields at most."""
    found = list(_fields(kind, from_bytes(first, kind), from_bytes(second, kind), ""))
    if not found:
        return "bytes that belong to no field"
    more = f", and {len(found) - 2} more fields" if len(found) > 2 else ""
    return ", ".join(found[:2]) + more


def largest(kind: str, first: bytes, second: bytes) -> float:
    """Return the largest absolute difference of any number in two messages; inf if they cannot be compared."""
    return max(_gaps(kind, from_bytes(first, kind), from_bytes(second, kind)), default=0.0)


def _parts(kind: str, first: Any, second: Any, path: str) -> Iterator[tuple[str, Any, Any]]:
    """Yield path and values of all fields that hold no messages."""
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
            yield f"{name}: {_short(a)} and {_short(b)}"


def _gaps(kind: str, first: Any, second: Any) -> Iterator[float]:
    for _, a, b in _parts(kind, first, second, ""):
        if isinstance(a, np.ndarray) and len(a) == len(b) and len(a):
            one, other = np.asarray(a, np.float64), np.asarray(b, np.float64)
            with np.errstate(invalid="ignore"):  # inf - inf
                gap = np.where((one == other) | (np.isnan(one) & np.isnan(other)), 0.0, np.abs(one - other))
            yield float(np.nan_to_num(gap, nan=np.inf).max())
        elif isinstance(a, int | float) and not isinstance(a, bool):
            yield 0.0 if a == b or (_is_nan(a) and _is_nan(b)) else float(abs(a - b))
        elif isinstance(a, np.ndarray) or a != b:
            yield 0.0 if np.array_equal(a, b) else float("inf")


def _is_nan(value: Any) -> bool:
    return isinstance(value, float) and value != value


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
