"""Fingerprints of a scenario, including all files that it refers to, and of this build; saved states contain both."""

from __future__ import annotations

import functools
import hashlib
import json
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal, get_origin

import numpy as np
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from uwsim import _core
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.water import LinearEnd, Water, WaterLevel

DERIVED = {(Water, "density_kg_m3")} | {(kind, "salinity_psu") for kind in (Water, WaterLevel, LinearEnd)}
"""Fields that are derived from others if they are left out; the value in effect counts, given or derived."""
WITHOUT_EFFECT = ("wire",)
"""Fields of a scenario on which no result depends."""


def scenario_fingerprint(scenario: Scenario) -> str:
    """Return a digest of the scenario, including its seed and the contents of its files: 16 hexadecimal digits.

    Fields with their default value are omitted, so fields added in later versions do not change the digest. The fields
    in WITHOUT_EFFECT are also omitted. Raises OSError if a file named in the scenario is missing.
    """
    plain = _plain(scenario)
    return _digest(json.dumps(plain, sort_keys=True).encode())


class BuildWarning(UserWarning):
    """Issued when a file was written by another build, since results may differ in the last bits."""


@functools.cache
def build_fingerprint() -> str:
    """Return a digest of the native module, which does the stepping: 16 hexadecimal digits."""
    return _digest(Path(_core.__file__).read_bytes())


def warn_of_other_build(what: str, build: str) -> None:
    """Warn if a file was saved by another build."""
    if build != build_fingerprint():
        warnings.warn(
            f"{what} is of another build of uwsim ({build}, this is {build_fingerprint()}): it continues, but not "
            "necessarily to the same bits",
            BuildWarning,
            stacklevel=3,
        )


def _plain(value: Any) -> Any:
    if isinstance(value, BaseModel):
        held = {name: _in_effect(value, name) for name in type(value).model_fields}
        return {
            name: _plain(held[name])
            for name, field in type(value).model_fields.items()
            if _counts(field, held[name]) and not (isinstance(value, Scenario) and name in WITHOUT_EFFECT)
        }
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


def _in_effect(model: BaseModel, name: str) -> Any:
    """Return the value of a field, or the one that is derived for it."""
    if (type(model), name) not in DERIVED or (isinstance(model, Water) and model.profile is not None):
        return getattr(model, name)
    assert isinstance(model, Water | WaterLevel | LinearEnd)
    return model.state().salinity if name == "salinity_psu" else model.state().density


def _counts(field: FieldInfo, value: Any) -> bool:
    """Return whether a field's value must be included: it differs from the default, has none, or names a variant."""
    if field.is_required() or get_origin(field.annotation) is Literal:
        return True
    default = field.get_default(call_default_factory=True, validated_data={})
    return type(value) is not type(default) or not bool(np.all(value == default))


def _digest(content: bytes) -> str:
    return hashlib.blake2b(content, digest_size=8).hexdigest()
