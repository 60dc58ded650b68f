"""An imaging sonar on a vehicle, as read from its YAML file, and the table of its kinds.

Kinds of the native core, and those that packages derive from them in Python, are registered in the entry point group
`uwsim.kinds.imaging_sonar`; docs/inside/extend.md adds one, and nothing else changes.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, GetJsonSchemaHandler, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from uwsim import _core
from uwsim.base import quaternions
from uwsim.base.named import did_you_mean
from uwsim.base.sockets import load, load_all, registered
from uwsim.scenario.spec.fields import Model, Point3, YawPitchRoll, broken
from uwsim.scenario.spec.json_schema import SensorFigure, one_of_kinds
from uwsim.scenario.spec.json_schema import figures as kind_figures
from uwsim.scenario.spec.sensor_kind import Figure, checked_values

GROUP = "uwsim.kinds.imaging_sonar"
FIGURE = "figure"
STRENGTHS = "strengths_db"
"""The only parameter that is a mapping, from surface names to backscatter strengths; the core uses labels instead of
names."""


def figure(default: float, low: float, high: float, unit: str = "", meaning: str = "") -> Any:
    """Return the dataclass field of a parameter that the core's kind does not have: a number in [low, high]."""
    return field(default=default, metadata={FIGURE: Figure(math.nan, low, high, unit, meaning)})


def own_figures(model: type[Any]) -> dict[str, Figure]:
    """Return the parameters of a model that the core's kind does not have."""
    return {each.name: each.metadata[FIGURE] for each in fields(model) if FIGURE in each.metadata}


def core_kind(model: type[Any]) -> str:
    """Return the kind of the core that computes a model's echoes: its own, or that of the model it is derived from.

    Raises ValueError for a model without one.
    """
    for base in model.__mro__:
        if (kind := base.__dict__.get("kind")) in _core.imaging_kinds():
            return str(kind)
    raise ValueError(f"{model.__name__}: must be derived from a model of {', '.join(_core.imaging_kinds())}")


@dataclass(frozen=True)
class ImagingKind:
    """A kind of imaging sonar.

    model: the class of its parameters, a dataclass whose defaults are those of a typical instrument. A kind of the core
    derives it from uwsim.instruments.sonars.imaging.Acoustics, another one from the model of such a kind, whose result
    it changes; its own parameters are fields made by `figure`. ping: called as ping(sim, world_from_sonar, model, name,
    *arguments); pings once from a vehicle at the current time and returns the kind's result.
    """

    model: type[Any]
    ping: Callable[..., Any]

    @property
    def name(self) -> str:
        """The kind."""
        return str(self.model.kind)

    @property
    def meaning(self) -> str:
        """A description."""
        if self.name == core_kind(self.model):
            return _core.imaging_kind(self.name).meaning
        return (inspect.getdoc(self.model) or "").partition("\n")[0].rstrip(".")

    @property
    def parameters(self) -> dict[str, SensorFigure]:
        """The keys of this kind, besides STRENGTHS."""
        return {**_core.imaging_kind(core_kind(self.model)).parameters, **own_figures(self.model)}


def imaging_kinds() -> list[str]:
    """Return the names of all kinds, uwsim's own first."""
    return list(registered(GROUP))


def usable_imaging_kinds() -> list[ImagingKind]:
    """Return all kinds, uwsim's own first. Warns with SocketWarning of those of broken packages."""
    return list(load_all(GROUP, _fitting).values())


@cache
def imaging_kind(name: str) -> ImagingKind:
    """Return a kind. Raises ValueError for an unknown name, or one whose package is broken."""
    found: ImagingKind = load(GROUP, name, _fitting)
    return found


def _fitting(name: str, kind: Any) -> ImagingKind:
    if not isinstance(kind, ImagingKind):
        raise TypeError(f"must be a {ImagingKind.__module__}.ImagingKind")
    if kind.name != name:
        raise TypeError(f"is named '{kind.name}'")
    for each in fields(kind.model):
        if each.name not in (*kind.parameters, STRENGTHS):
            raise TypeError(f"{kind.model.__name__}.{each.name}: must be made by {figure.__module__}.figure")
    return kind


RADIANS, DEGREES = "_rad", "_deg"
LOUDEST_DB = 300.0


class ImagingMount(Model):
    """An imaging sonar of one of _core.imaging_kinds(), and its mount: x ahead, y to port, z up; pitch positive down.

    Parameters that differ from the kind's defaults (see `sonars/imaging/`) are written next to the other keys in YAML,
    with angles in degrees under names that end in _deg. position_m: position in the body frame. figures: in Python,
    these parameters under their own names and in SI units.
    """

    kind: str
    position_m: Point3 = (0.0, 0.0, 0.0)
    yaw_pitch_roll_deg: YawPitchRoll = (0.0, 0.0, 0.0)
    figures: dict[str, Any] = Field(default_factory=dict)

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        schema = super().__get_pydantic_json_schema__(core, handler)
        kinds = {}
        for kind in usable_imaging_kinds():
            name = kind.name
            kinds[name] = kind_figures(kind.parameters, in_degrees=True) | {"description": kind.meaning, "required": []}
            for key, parameter in kind.parameters.items():
                if not np.isnan(parameter.by_default):
                    own = kinds[name]["properties"][_yaml_key(key)]
                    own["type"] = [own["type"], "null"]
            kinds[name]["properties"][STRENGTHS] = {
                "type": "object",
                "additionalProperties": {"type": "number", "minimum": -LOUDEST_DB, "maximum": LOUDEST_DB},
                "description": "Backscatter strength of each surface by name, instead of its material's, dB",
            }
        one_of_kinds(handler.resolve_ref_schema(schema), kinds, without={"figures"})
        return schema

    @model_validator(mode="before")
    @classmethod
    def _collect_figures(cls, data: object) -> object:
        if not isinstance(data, Mapping) or "kind" not in data:
            return data
        kinds = imaging_kinds()
        if data["kind"] not in kinds:
            hint = did_you_mean(str(data["kind"]), kinds)
            raise broken(f"must be one of {', '.join(kinds)}{hint}", at=("kind",), value=str(data["kind"]))
        names = {_yaml_key(name): name for name in (*imaging_kind(data["kind"]).parameters, STRENGTHS)}
        own = {key: value for key, value in data.items() if key not in names}
        for key in own:
            if key not in cls.model_fields:
                hint = did_you_mean(str(key), [*cls.model_fields, *names])
                raise broken(f"unknown key{hint}", at=(str(key),))
        given = {names[key]: _figure(data["kind"], names[key], value) for key, value in data.items() if key in names}
        return {**own, "figures": {**own.get("figures", {}), **given}}

    @model_validator(mode="after")
    def _check_figures(self) -> ImagingMount:
        known = (*imaging_kind(self.kind).parameters, STRENGTHS)
        for name, value in self.figures.items():
            if name not in known:
                raise broken(f"unknown parameter of a {self.kind}{did_you_mean(name, known)}", at=("figures", name))
            _check(self.kind, name, value, key=name)
        return self

    def body_from_sonar(self) -> NDArray[np.float64]:
        """Return the transform from the sonar's frame to the body's, (4, 4)."""
        matrix = np.eye(4)
        matrix[:3, :3] = quaternions.matrix(quaternions.of_yaw_pitch_roll_deg(self.yaw_pitch_roll_deg))
        matrix[:3, 3] = self.position_m
        return matrix


def _yaml_key(name: str) -> str:
    return name.removesuffix(RADIANS) + DEGREES if name.endswith(RADIANS) else name


def _figure(kind: str, name: str, value: Any) -> Any:
    """Convert a parameter's YAML value to the stored value."""
    key = _yaml_key(name)
    _check(kind, name, value, key=key)
    return value if key == name else float(np.radians(value))


def _check(kind: str, name: str, value: Any, *, key: str) -> None:
    if name == STRENGTHS:
        if not isinstance(value, Mapping):
            raise broken("must be a strength in dB for each surface, by name", at=(key,), value=value)
        for surface, strength_db in value.items():
            is_number = isinstance(strength_db, int | float) and not isinstance(strength_db, bool)
            if not (is_number and abs(strength_db) <= LOUDEST_DB):  # also false for NaN
                rule = f"must be a number in [{-LOUDEST_DB:g}, {LOUDEST_DB:g}] dB"
                raise broken(rule, at=(key, str(surface)), value=strength_db, unit="dB")
        return
    parameter = imaging_kind(kind).parameters[name]
    if value is None and not np.isnan(parameter.by_default):
        return
    checked_values(key, value, parameter, in_degrees=key != name)
