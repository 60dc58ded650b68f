"""Field types of the scenario models: a strict base class, numbers with range and unit, names, files.

Each rule is part of a type, so that it applies to YAML and Python alike. Errors carry the unit and the rule;
read/validation_errors.py adds file and line.
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, get_args, get_origin

import numpy as np
from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    WithJsonSchema,
    model_validator,
)
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, PydanticCustomError, core_schema
from pydantic_core.core_schema import ValidationInfo

from uwsim.base.named import did_you_mean
from uwsim.base.saved_state import DEFER_BUILD
from uwsim.scenario.read.assets import find_asset, packaged_names
from uwsim.scenario.read.validation_errors import HINTS, HINTS_MAX
from uwsim.scenario.spec.json_schema import ONE_OF, described, in_range

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,39}")


class Model(BaseModel):
    """Base of all scenario models: immutable; an unknown key is an error that suggests the most similar known key.

    Building a validator takes longer than defining a model, so each is built when it is first used. Constants and
    defaults are therefore made by `model_construct`, which does not validate.
    """

    one_of: ClassVar[tuple[str, ...]] = ()
    """Fields of which a value states one; a form that sets it removes the others."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, defer_build=DEFER_BUILD)

    def __setattr__(self, name: str, value: Any) -> None:
        if not name.startswith("_"):
            rule = "cannot be assigned: it is fixed; make another with model_copy(update={...})"
            raise AttributeError(f"{type(self).__name__}.{name} {rule}")
        super().__setattr__(name, value)

    def given(self) -> dict[str, Any]:
        """Return the fields whose presence carries information: fields set explicitly, and the name of a variant."""
        present, (variants, defaults) = self.model_fields_set, _present_unset(type(self))
        return {
            name: getattr(self, name)
            for name in type(self).model_fields
            # A default dict may have been filled in the meantime.
            if name in present
            or name in variants
            or (name in defaults and getattr(self, name) != defaults[name](self.__dict__))
        }

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        schema = handler(core)
        described(cls, found := handler.resolve_ref_schema(schema))
        for name in cls.one_of:
            found["properties"][name][ONE_OF] = list(cls.one_of)
        return schema

    @model_validator(mode="before")
    @classmethod
    def _check_keys(cls, data: object, info: ValidationInfo) -> object:
        """Note the most similar known key for each unknown one, for the message; pydantic rejects unknown keys."""
        hints = (info.context or {}).get(HINTS)
        for key in data if isinstance(data, Mapping) else ():
            if key not in cls.model_fields:
                hint = did_you_mean(str(key), cls.model_fields) if len(hints or ()) < HINTS_MAX else ""
                if hints is None:
                    raise broken(f"unknown key{hint}", at=(str(key),))
                hints[key] = hint
        return data


@cache
def _present_unset(model: type[Model]) -> tuple[frozenset[str], dict[str, Callable[[Mapping[str, Any]], Any]]]:
    """Return the fields of a model that may carry information unset: names of a variant, and what makes a default."""
    fields = model.model_fields
    kinds = {name: field.annotation for name, field in fields.items()}
    variants = {name for name, kind in kinds.items() if get_origin(kind) is Literal and len(get_args(kind)) == 1}
    made: dict[str, Any] = {name: field.default_factory for name, field in fields.items() if field.default_factory}
    from_data = {name for name in made if fields[name].default_factory_takes_validated_data}
    defaults = {name: make if name in from_data else lambda _, make=make: make() for name, make in made.items()}
    return frozenset(variants), defaults


def broken(rule: str, *, at: tuple[str | int, ...] = (), **context: Any) -> PydanticCustomError:
    """Return the error to raise for a broken rule. at: keys below the model that raises it.

    context: the `value` and its `unit`.
    """
    return PydanticCustomError("rule", "{rule}", {"rule": rule, "at": at, **context})


@dataclass(frozen=True)
class InRange:
    """A number in [low, high], including NumPy types but not text or booleans; whole if the field is an int.

    beyond: what to use for a number above, for messages.
    """

    low: float
    high: float
    unit: str = ""
    beyond: str = ""

    def __get_pydantic_core_schema__(self, source: type, handler: GetCoreSchemaHandler) -> CoreSchema:
        if source is int:
            plain = core_schema.no_info_before_validator_function(_plain_int, core_schema.int_schema(strict=True))
        else:
            number = core_schema.float_schema(strict=True, allow_inf_nan=True)
            plain = core_schema.no_info_before_validator_function(_plain_float, number)
        return core_schema.no_info_after_validator_function(self._check, plain)

    def __get_pydantic_json_schema__(self, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return in_range(handler(core)["type"], self.low, self.high, self.unit)

    def _check(self, value: float) -> float:
        if not self.low <= value <= self.high:  # also false for NaN
            rule = f"must be in [{self.low:.12g}, {self.high:.12g}] {self.unit}".rstrip()
            raise broken(rule + (f"; {self.beyond}" if self.beyond and value > self.high else ""), unit=self.unit)
        return value


@dataclass(frozen=True)
class OneOf:
    """Text that must be one of these names."""

    names: Sequence[str]

    def __get_pydantic_core_schema__(self, source: type, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_after_validator_function(self.check, handler(source))

    def __get_pydantic_json_schema__(self, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return {"enum": list(self.names)}

    def check(self, value: str) -> str:
        """Return the text. Raises an error of validation unless it is one of the names."""
        if value not in self.names:
            raise broken(f"must be one of {', '.join(self.names)}{did_you_mean(value, self.names)}")
        return value


@dataclass(frozen=True)
class AssetName:
    """Schema annotation: a packaged name, which editors complete, or a path. kind: a folder in the assets."""

    kind: str

    def __get_pydantic_json_schema__(self, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return {"anyOf": [{"enum": packaged_names(self.kind)}, {"type": "string"}]}


def _plain_int(value: object) -> object:
    """Convert NumPy integers to Python integers; leave anything else, including booleans, to be rejected later."""
    if isinstance(value, np.bool_):
        return bool(value)
    if isinstance(value, int) or not hasattr(value, "__index__"):
        return value
    try:
        return operator.index(value)
    except TypeError:  # arrays
        return value


def _plain_float(value: object) -> object:
    """Convert NumPy numbers to Python floats; a whole number too large for a float becomes infinite."""
    value = _plain_int(value)
    if isinstance(value, np.floating):
        return float(value)
    try:
        return float(value) if type(value) is int else value
    except OverflowError:
        return math.inf


def _check_name(name: str) -> str:
    if not NAME.fullmatch(name):
        raise broken("must be a letter followed by at most 39 letters, digits, '-' or '_'")
    return name


def asset_at(value: object, info: ValidationInfo) -> Path:
    """Return the file that a field names, see AssetFile. Raises an error of validation."""
    if not isinstance(value, str | Path):
        raise broken("must be the path of a file")
    folder = (info.context or {}).get("folder", Path())
    found = find_asset(Path(value), folder)
    if found is None:
        raise broken(f"no such file in {folder.resolve()} nor among the packaged assets")
    return found


Name = Annotated[str, AfterValidator(_check_name), WithJsonSchema({"type": "string", "pattern": f"^{NAME.pattern}$"})]

_PathText = Annotated[str, WithJsonSchema({"type": "string", "format": "path"})]
AssetFile = Annotated[Path, BeforeValidator(asset_at, json_schema_input_type=_PathText)]
"""An existing file: relative to the YAML file that names it (in Python: to the working folder), or else packaged."""
_MeshText = Annotated[str, WithJsonSchema({"type": "string", "format": "mesh"})]
MeshFile = Annotated[Path, BeforeValidator(asset_at, json_schema_input_type=_MeshText)]
"""The same for a mesh."""

# Rays are traced in float32, which resolves a millimetre within 10 km.
Metres = Annotated[float, InRange(-10_000, 10_000, "m")]
Size = Annotated[float, InRange(0.01, 10_000, "m")]
Degrees = Annotated[float, InRange(-360, 360, "deg")]
NoseDown = Annotated[float, InRange(-90, 90, "deg")]
"""A sonar's tilt, positive nose down."""
Factor = Annotated[float, InRange(1e-6, 1e6)]

Point2 = tuple[Metres, Metres]
Point3 = tuple[Metres, Metres, Metres]
YawPitchRoll = tuple[Degrees, Degrees, Degrees]
"""Rotations about z, then the new y, then the new x, in degrees."""
