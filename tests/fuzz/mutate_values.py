"""Mutates JSON or YAML value by value, since changed bytes rarely leave it valid, and seldom get past the parser."""

from __future__ import annotations

import json
from random import Random
from typing import Any

from tests.fuzz.readers import Values

JUNK: tuple[Any, ...] = (
    *(None, True, False, 0, 1, -1, 0.5, -0.0, 1e-320, 1e308, -1e308, 2**31, 2**63, -(2**63), 2**70, 10**400),
    *("", "x", "nan", "../up", "/dev/zero", "\0", "a" * 5000, [], {}, [[]], [0], {"": 0}),
    *(float("nan"), float("inf"), [[[[[[[[]]]]]]]], list(range(100))),
)
Path = tuple[Any, ...]


def mutated(data: bytes, values: Values, rng: Random) -> bytes | None:
    """Return the input with one to three values changed; None if it cannot be read."""
    try:
        holder = [values.read(data)]
        for _ in range(rng.randrange(1, 4)):
            _change(holder, rng.choice(_paths(holder)[1:]), rng)
        return values.write(holder[0])
    except Exception:  # not JSON, or nested too deeply for it
        return None


def _paths(value: Any, at: Path = ()) -> list[Path]:
    keys = list(value) if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else []
    return [at, *(path for key in keys for path in _paths(value[key], (*at, key)))]


def _change(whole: Any, path: Path, rng: Random) -> None:
    """Change the value at a path: replace, remove, repeat or rename it."""
    parent = _at(whole, path[:-1])
    key, value, how = path[-1], parent[path[-1]], rng.randrange(6)
    if how == 0 and len(path) > 1:
        del parent[key]
    elif how == 1 and isinstance(parent, list) and len(path) > 1:
        parent[key:key] = [value] * rng.choice((1, 2, 50))
    elif how == 1 and isinstance(parent, dict):
        parent[rng.choice((f"{key}x", "", "name", "0"))] = value
    elif how == 2:
        parent[key] = json.loads(json.dumps(_at(whole, rng.choice(_paths(whole)[1:])), default=str))
    elif how == 3 and isinstance(value, int | float) and abs(value) < 1e300:
        parent[key] = rng.choice((-value, value + 1, value * 1e6, value / 1e6, int(value) if abs(value) < 1e9 else 0))
    else:
        parent[key] = rng.choice(JUNK)


def _at(whole: Any, path: Path) -> Any:
    for key in path:
        whole = whole[key]
    return whole
