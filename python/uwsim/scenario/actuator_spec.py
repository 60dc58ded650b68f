"""Thrusters and fins, as read from YAML: a thruster's type from its own file, where it sits from the vehicle's.

Body frame: x forward, y left, z up.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, model_validator
from pydantic_core.core_schema import ValidationInfo

from uwsim import _core
from uwsim.scenario.document import read_document
from uwsim.scenario.fields import InRange, Model, Name, Point3, broken
from uwsim.scenario.messages import validated
from uwsim.scenario.paths import assets_folder, find_yaml

Newton = Annotated[float, InRange(-1e6, 1e6, "N")]
Microseconds = Annotated[float, InRange(1, 10_000, "us")]
Component = Annotated[float, InRange(-1e6, 1e6)]
Direction = tuple[Component, Component, Component]
"""Of any length but zero."""


class Pwm(Model):
    """How a speed controller's pulse widths stand for commands: centre_us is 0, centre_us +- span_us are +-1."""

    centre_us: Microseconds
    span_us: Microseconds


class ThrusterType(Model):
    """A thruster as one buys it.

    thrust_n: pairs of a command in [-1, 1], or of a pulse width where `pwm` is given, and the still-water thrust on the
    vehicle; linear between, constant beyond the ends. time_constant_s: of the thrust's first-order lag.
    bollard_coefficient: T / (rho n^2 D^4) at rest. zero_thrust_advance_ratio: u_a / (n D) at which no thrust is left;
    without it inflow costs nothing. torque_per_thrust_m: the propeller's torque for each newton, k_q = D K_Q / K_T.
    """

    name: Name
    description: str = ""
    pwm: Pwm | None = None
    thrust_n: Annotated[tuple[tuple[Component, Newton], ...], Field(min_length=2, max_length=1000)]
    time_constant_s: Annotated[float, InRange(0, 60, "s")]
    diameter_m: Annotated[float, InRange(0.001, 10, "m")]
    bollard_coefficient: Annotated[float, InRange(1e-3, 10)] = 0.45
    zero_thrust_advance_ratio: Annotated[float, InRange(1e-2, 100)] | None = None
    torque_per_thrust_m: Annotated[float, InRange(0, 10, "m")] = 0.0

    @model_validator(mode="after")
    def _has_a_curve(self) -> ThrusterType:
        try:
            self.curve()
        except ValueError as error:
            raise broken(str(error).rpartition(": ")[2], at=("thrust_n",)) from None
        return self

    def curve(self) -> _core.ThrustCurve:
        """Return thrust against command in [-1, 1]. Raises ValueError."""
        centre, span = (self.pwm.centre_us, self.pwm.span_us) if self.pwm else (0.0, 1.0)
        commands = [(given - centre) / span for given, _ in self.thrust_n]
        return _core.ThrustCurve(commands, [thrust_n for _, thrust_n in self.thrust_n])


def load_thruster(source: str | Path, folder: Path | None = None) -> ThrusterType:
    """Load a type from a packaged name ("t200_16v") or a path, relative to `folder`. Raises ScenarioError."""
    beside = (folder or Path()) / source
    path = beside if beside.is_file() else find_yaml(source, "thrusters")
    document = read_document(path, path.name if assets_folder() in path.parents else str(path))
    return validated(ThrusterType, document.values, document, folder=path.resolve().parent)


def _thruster_type(value: object, info: ValidationInfo) -> object:
    return load_thruster(value, (info.context or {}).get("folder")) if isinstance(value, str | Path) else value


def _require_direction(direction: Direction, key: str) -> None:
    if math.hypot(*direction) < 1e-6:
        raise broken("must point somewhere", at=(key,), value=list(direction))


class ThrusterMount(Model):
    """A thruster on a vehicle. axis: where a positive thrust pushes. spin: seen from behind, as it thrusts ahead."""

    model: Annotated[ThrusterType, BeforeValidator(_thruster_type)]
    position_m: Point3
    axis: Direction
    spin: Literal["clockwise", "counter-clockwise"] = "clockwise"

    @model_validator(mode="after")
    def _points_somewhere(self) -> ThrusterMount:
        _require_direction(self.axis, "axis")
        return self

    def core_spec(self, name: str) -> _core.ThrusterParameters:
        """Return it as the core takes it."""
        kind = self.model
        spec = _core.ThrusterParameters(name, self.position_m, self.axis, kind.curve())
        spec.time_constant_s = kind.time_constant_s
        spec.diameter_m = kind.diameter_m
        spec.bollard_coefficient = kind.bollard_coefficient
        spec.zero_thrust_advance_ratio = kind.zero_thrust_advance_ratio or math.inf
        spec.torque_per_thrust_m = kind.torque_per_thrust_m
        spec.spin = 1 if self.spin == "clockwise" else -1
        return spec


class FinMount(Model):
    """A lifting surface: a fin that turns about `span`, right-handed, or a fixed one (deflection_max_deg 0).

    position_m: its centre of pressure. aspect_ratio: effective, span^2 / area, doubled where the hull mirrors the fin.
    efficiency: Oswald's. stall_angle_deg: none for a surface that does not stall, such as a hull's lift.
    """

    position_m: Point3
    span: Direction
    area_m2: Annotated[float, InRange(1e-6, 1000, "m2")]
    aspect_ratio: Annotated[float, InRange(1e-3, 100)]
    parasitic_drag: Annotated[float, InRange(0, 10)] = 0.0
    efficiency: Annotated[float, InRange(0.1, 1)] = 0.9
    stall_angle_deg: Annotated[float, InRange(1, 90, "deg")] | None = None
    stall_sharpness_deg: Annotated[float, InRange(0.1, 30, "deg")] = 2.0
    deflection_max_deg: Annotated[float, InRange(0, 90, "deg")] = 0.0
    rate_max_deg_s: Annotated[float, InRange(0.1, 10_000, "deg/s")] = 60.0

    @model_validator(mode="after")
    def _stands_across_the_flow(self) -> FinMount:
        _require_direction(self.span, "span")
        if abs(self.span[0]) > 1e-6 * math.hypot(*self.span):
            raise broken("must be across x", at=("span",), value=list(self.span))
        return self

    def core_spec(self, name: str) -> _core.FinParameters:
        """Return it as the core takes it."""
        spec = _core.FinParameters(name, self.position_m, self.span, self.area_m2, self.aspect_ratio)
        spec.parasitic_drag = self.parasitic_drag
        spec.efficiency = self.efficiency
        spec.stalls = self.stall_angle_deg is not None
        if self.stall_angle_deg is not None:
            spec.stall_angle_rad = math.radians(self.stall_angle_deg)
            spec.stall_sharpness_rad = math.radians(self.stall_sharpness_deg)
        spec.deflection_max_rad = math.radians(self.deflection_max_deg)
        spec.rate_max_rad_s = math.radians(self.rate_max_deg_s)
        return spec
