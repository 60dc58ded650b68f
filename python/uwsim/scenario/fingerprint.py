"""Fingerprints of a scenario, with every file that it names, and of this build: a saved state belongs to both."""

from __future__ import annotations

import functools
import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from uwsim import _core
from uwsim.scenario.spec.scenario import Scenario


def scenario_fingerprint(scenario: Scenario) -> str:
    """Digest all of the scenario, its seed and the content of its files included, to 16 hexadecimal digits.

    Raises OSError if a file that the scenario names is gone.
    """
    plain = _plain(scenario.model_dump())
    return _digest(json.dumps(plain, sort_keys=True).encode())


@functools.cache
def build_fingerprint() -> str:
    """Digest the native module, which computes the steps, to 16 hexadecimal digits."""
    return _digest(Path(_core.__file__).read_bytes())


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [_plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, Path):
        return _digest(value.read_bytes())
    if value is None or isinstance(value, str | int | float):
        return value
    raise TypeError(f"a scenario's field is a {type(value).__name__}: convert it to plain values here")


def _digest(content: bytes) -> str:
    return hashlib.blake2b(content, digest_size=8).hexdigest()
