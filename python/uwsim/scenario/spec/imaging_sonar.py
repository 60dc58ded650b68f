"""An imaging sonar on a vehicle, as read from its YAML file: kind, mount and overridden parameters.

The kinds and their parameters are in the table of imaging_kind.py: a new kind needs no change here.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, GetJsonSchemaHandler, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from uwsim.base import quaternions
from uwsim.base.did_you_mean import did_you_mean
from uwsim.scenario.spec.fields import Model, Point3, YawPitchRoll, broken
from uwsim.scenario.spec.imaging_kind import STRENGTHS, imaging_kind, imaging_kinds, usable_imaging_kinds
from uwsim.scenario.spec.json_schema import figures as kind_figures
from uwsim.scenario.spec.json_schema import one_of_kinds
from uwsim.scenario.spec.parameter import checked_values

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
