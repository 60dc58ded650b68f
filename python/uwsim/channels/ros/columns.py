"""Messages of columns: one message that stands for n, which are encoded at once.

In such a message, a number may be a column (n,) and an array of numbers (n, length); all else, such as texts and the
lengths of sequences, is the same in all n.
"""

from __future__ import annotations

from typing import Any, NamedTuple, cast

import numpy as np

from uwsim.channels.ros.cdr import HEADER
from uwsim.channels.ros.message_types import kind_of, typestore

DTYPES = {"byte": "i1", "char": "u1"} | {
    name: np.dtype(name).str[1:]
    for name in ("bool", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "float32", "float64")
}
LENGTH = "u4"


class Part(NamedTuple):
    """A number, an array of them, or a text, at its place after the header."""

    at: int
    dtype: np.dtype[Any]
    value: Any


def encode_all(message: Any, count: int) -> list[bytes]:
    """Encode the n messages of a message of columns: as `cdr.encode` encodes each of them.

    Raises ValueError if a column is not as long as `count`, or an array not as long as its type demands.
    """
    parts: list[Part] = []
    size = _place(message.__msgtype__, message, 0, parts)
    layout = np.dtype(
        {
            "names": [str(k) for k in range(len(parts) + 1)],
            "formats": [f"S{len(HEADER)}", *(part.dtype for part in parts)],
            "offsets": [0, *(len(HEADER) + part.at for part in parts)],
            "itemsize": len(HEADER) + -(-size // 4) * 4,
        }
    )
    rows = np.zeros(count, layout)
    rows["0"] = HEADER
    for k, part in enumerate(parts, 1):
        rows[str(k)] = part.value
    return cast(list[bytes], rows.view(np.dtype((np.void, layout.itemsize))).tolist())


def _place(name: str, message: Any, at: int, parts: list[Part]) -> int:
    """Append the parts of a message that begins at an offset; return where it ends."""
    for field, description in typestore().fielddefs[name][1]:
        kind, value = kind_of(description), getattr(message, field)
        if kind.length is None:
            at = _place_one(kind.base, value, at, parts)
            continue
        if kind.length == 0:  # a sequence
            length = value.shape[-1] if isinstance(value, np.ndarray) else len(value)
            at = _append(at, np.dtype(LENGTH), length, parts)
        if isinstance(value, np.ndarray):
            if kind.length not in (0, value.shape[-1]):
                raise ValueError(f"{name}.{field}: has {value.shape[-1]} numbers: must have {kind.length}")
            if value.shape[-1]:
                at = _append(at, np.dtype((DTYPES[kind.base], value.shape[-1:])), value, parts)
        else:
            for each in value:
                at = _place_one(kind.base, each, at, parts)
    return at


def _place_one(base: str, value: Any, at: int, parts: list[Part]) -> int:
    if base in DTYPES:
        return _append(at, np.dtype(DTYPES[base]), value, parts)
    if base != "string":
        return _place(base, value, at, parts)
    text = value.encode()
    at = _append(at, np.dtype(LENGTH), len(text) + 1, parts)
    parts.append(Part(at, np.dtype(f"S{len(text) + 1}"), text))  # a text ends with a zero
    return at + len(text) + 1


def _append(at: int, dtype: np.dtype[Any], value: Any, parts: list[Part]) -> int:
    at += -at % dtype.base.itemsize
    parts.append(Part(at, dtype, value))
    return at + dtype.itemsize
