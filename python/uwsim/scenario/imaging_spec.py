"""An imaging sonar on a vehicle, as read from its YAML file: what kind, where, and what is not as by default.

Which kinds there are, and which figures each takes, `uwsim.imaging` tells: a new figure there needs nothing here.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np
from pydantic import Field, model_validator
from scipy.spatial.transform import Rotation

from uwsim import imaging
from uwsim.scenario.fields import Model, Point3, YawPitchRoll, broken
from uwsim.scenario.paths import did_you_mean

RADIANS, DEGREES = "_rad", "_deg"


class ImagingMount(Model):
    """An imaging sonar of one of imaging.KINDS, and where it sits on the body: x ahead, y to port, z up; pitch is down.

    Figures of its kind (see uwsim.imaging) stand beside the others in YAML, angles in degrees under names that end in
    _deg, and in `figures` here by their own names, in SI units.
    """

    kind: str
    position_m: Point3 = (0.0, 0.0, 0.0)
    yaw_pitch_roll_deg: YawPitchRoll = (0.0, 0.0, 0.0)
    figures: dict[str, Any] = Field(default_factory=dict)

    @model_validator(mode="before")
    @classmethod
    def _gathers_figures(cls, data: object) -> object:
        if not isinstance(data, Mapping) or "kind" not in data:
            return data
        if data["kind"] not in imaging.KINDS:
            hint = did_you_mean(str(data["kind"]), imaging.KINDS)
            raise broken(f"must be one of {', '.join(imaging.KINDS)}{hint}", at=("kind",), value=str(data["kind"]))
        taken = {_yaml_name(field.name): field.name for field in fields(imaging.KINDS[data["kind"]])}
        own = {key: value for key, value in data.items() if key not in taken}
        for key in own:
            if key not in cls.model_fields:
                hint = did_you_mean(str(key), [*cls.model_fields, *taken])
                raise broken(f"unknown key{hint}", at=(str(key),))
        given = {taken[key]: _in_radians(key, data[key]) for key in data if key in taken}
        return {**own, "figures": {**own.get("figures", {}), **given}}

    @model_validator(mode="after")
    def _is_a_sonar(self) -> ImagingMount:
        try:
            imaging.check(self.sonar())
        except TypeError as error:  # a figure that its kind does not know, named in `figures` itself
            raise broken(f"not of a {self.kind}: {', '.join(map(str, self.figures))}", at=("figures",)) from error
        except ValueError as error:
            path, _, rule = str(error).partition(": ")
            name = path.removeprefix("sonar.").partition(" = ")[0].partition("[")[0]
            value = self.figures.get(name)
            if name.endswith(RADIANS) and isinstance(value, float):
                raise broken(rule, at=(_yaml_name(name),), value=float(np.degrees(value)), unit="deg") from error
            raise broken(rule or str(error), at=(name,) if name in self.figures else (), value=value) from error
        return self

    def sonar(self) -> imaging.Acoustics:
        """The sonar's model, as uwsim.imaging takes it."""
        return imaging.KINDS[self.kind](**self.figures)

    def body_from_sonar(self) -> imaging.Matrix:
        """(4, 4)."""
        matrix = np.eye(4)
        matrix[:3, :3] = Rotation.from_euler("ZYX", self.yaw_pitch_roll_deg, degrees=True).as_matrix()
        matrix[:3, 3] = self.position_m
        return matrix


def _yaml_name(name: str) -> str:
    return name.removesuffix(RADIANS) + DEGREES if name.endswith(RADIANS) else name


def _in_radians(key: str, value: object) -> object:
    if not key.endswith(DEGREES):
        return value
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise broken("must be a number", at=(key,), value=value)
    return float(np.radians(value))
