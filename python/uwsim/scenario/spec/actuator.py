"""Thrusters, fins and the gains of the loops that command them. Thruster types have their own files.

Body frame: x forward, y left, z up.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field, TypeAdapter, model_validator
from pydantic_core.core_schema import ValidationInfo

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.scenario.read.assets import shown_name
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.spec_file import read_sheet_rows, read_spec
from uwsim.scenario.spec.fields import AssetFile, AssetName, InRange, Model, Name, Point3, broken
from uwsim.scenario.spec.kinds import Kinds

Newton = Annotated[float, InRange(-1e6, 1e6, "N")]
Microseconds = Annotated[float, InRange(1, 10_000, "us")]
Component = Annotated[float, InRange(-1e6, 1e6)]
ThrusterName = Annotated[str, AssetName("thrusters")]
Direction = tuple[Component, Component, Component]
"""A vector of nonzero length."""
COMMANDS = np.linspace(-1.0, 1.0, 801)  # at which a law of thrust is evaluated, once, when its thruster is read


class Pwm(Model):
    """The pulse widths of a speed controller.

    centre_us: width for command 0. span_us: difference from the centre to commands -1 and 1.
    """

    centre_us: Microseconds
    span_us: Microseconds


class ThrustLaw(Model):
    """The still-water thrust of a propeller whose speed has settled, in place of a measured table.

    Kinds are registered in the entry point group `uwsim.kinds.thrust`, and have the field `kind`.
    """

    if TYPE_CHECKING:
        kind: str

    def thrusts_n(self, commands: Floats) -> Floats:
        """Return the thrust [N] at each command in [-1, 1], which never decreases, and is 0 at 0: (n,) to (n,)."""
        raise NotImplementedError


class BySpeed(ThrustLaw):
    """A propeller whose speed is proportional to the command: T = K_T rho n |n| D^4 (Fossen 2011, sec. 9.1).

    max_rpm: its speed at full command. diameter_m: D. thrust_coefficient: K_T at rest, in still water. astern: the
    part of the thrust ahead that the same speed gives astern. dead_band: the command below which the motor stands.
    density_kg_m3: rho, of the water in which thrust_coefficient was measured.
    """

    kind: Literal["speed"]
    max_rpm: Annotated[float, InRange(1, 100_000, "rpm")]
    diameter_m: Annotated[float, InRange(0.001, 10, "m")]
    thrust_coefficient: Annotated[float, InRange(1e-3, 10)]
    astern: Annotated[float, InRange(0, 10)] = 1.0
    dead_band: Annotated[float, InRange(0, 0.99)] = 0.0
    density_kg_m3: Annotated[float, InRange(500, 1500, "kg/m3")] = 1000.0

    def thrusts_n(self, commands: Floats) -> Floats:
        """Return the thrust by the square of the speed."""
        speed = np.where(np.abs(commands) < self.dead_band, 0.0, self.max_rpm / 60.0 * commands)
        thrust_n = self.thrust_coefficient * self.density_kg_m3 * self.diameter_m**4 * speed * np.abs(speed)
        return thrust_n * np.where(speed < 0.0, self.astern, 1.0)


ThrustLawKind = Annotated[Any, Kinds("uwsim.kinds.thrust", ThrustLaw)]
ThrustTable = Annotated[tuple[tuple[Component, Newton], ...], Field(min_length=2, max_length=1000)]


def _tabulated(value: object, info: ValidationInfo) -> object:
    """Return the table of a law of thrust, by pulse widths if the type has them; anything else as it is."""
    if not isinstance(value, Mapping):
        return value
    law: ThrustLaw = TypeAdapter(ThrustLawKind).validate_python(value, context=info.context)
    thrusts_n = np.asarray(law.thrusts_n(COMMANDS))
    if thrusts_n.shape != COMMANDS.shape:
        raise broken(f"kind '{law.kind}' returns thrusts of shape {thrusts_n.shape}, not {COMMANDS.shape}")
    pwm = info.data.get("pwm")
    return list(zip(COMMANDS if pwm is None else pwm.centre_us + pwm.span_us * COMMANDS, thrusts_n, strict=True))


class ThrusterType(Model):
    """A type of thruster, as sold.

    pwm: the pulse widths, if thrust_n is tabulated by them. thrust_n: pairs of a command in [-1, 1], or a pulse width
    if `pwm` is given, and the still-water thrust on the vehicle; linear between pairs, constant beyond the ends. Or a
    law, such as {kind: speed, max_rpm: 3500, diameter_m: 0.076, thrust_coefficient: 0.445}, which is then tabulated.
    sheets: a CSV file of thrust, current and revolutions measured at several supply voltages (columns voltage_v,
    command, thrust_n, current_a, rpm; commands as in thrust_n), used by vehicles with a `battery`. time_constant_s:
    time constant of the thrust's first-order lag. diameter_m: diameter of the propeller. bollard_coefficient: T / (rho
    n^2 D^4) at rest. zero_thrust_advance_ratio: u_a / (n D) at which thrust vanishes; without it, inflow does not
    reduce thrust. torque_per_thrust_m: the propeller's torque per newton of thrust, k_q = D K_Q / K_T.
    """

    name: Name
    description: str = ""
    pwm: Pwm | None = None
    thrust_n: Annotated[ThrustTable, BeforeValidator(_tabulated, json_schema_input_type=ThrustTable | ThrustLawKind)]
    sheets: AssetFile | None = None
    time_constant_s: Annotated[float, InRange(0, 60, "s")]
    diameter_m: Annotated[float, InRange(0.001, 10, "m")]
    bollard_coefficient: Annotated[float, InRange(1e-3, 10)] = 0.45
    zero_thrust_advance_ratio: Annotated[float, InRange(1e-2, 100)] | None = None
    torque_per_thrust_m: Annotated[float, InRange(0, 10, "m")] = 0.0

    @model_validator(mode="after")
    def _has_a_curve(self) -> ThrusterType:
        try:
            _core.ThrustCurve(*self.curve_points)
        except ValueError as error:
            raise broken(str(error).rpartition(": ")[2], at=("thrust_n",)) from None
        return self

    @property
    def curve_points(self) -> tuple[list[float], list[float]]:
        """Commands in [-1, 1] and their thrusts [N]."""
        centre, span = self._scale
        commands = [(given - centre) / span for given, _ in self.thrust_n]
        return commands, [thrust_n for _, thrust_n in self.thrust_n]

    def performance(self, gain: float = 1.0) -> _core.ThrusterSheets:
        """Return the sheets. gain: a factor on the thrust. Raises ScenarioError if they are missing or invalid."""
        if self.sheets is None:
            raise ScenarioError(f"thruster '{self.name}' has no `sheets` of its performance by voltage")
        centre, span = self._scale
        return _performance(self.sheets, self.sheets.stat().st_mtime_ns, centre, span, gain)

    @property
    def _scale(self) -> tuple[float, float]:
        """The tabulated value for command 0, and the difference between the values for commands 1 and 0."""
        return (self.pwm.centre_us, self.pwm.span_us) if self.pwm else (0.0, 1.0)


@lru_cache(maxsize=64)  # a vehicle's thrusters share a file, which its alarms read twice a second
def _performance(path: Path, _modified_ns: int, centre: float, span: float, gain: float) -> _core.ThrusterSheets:
    sheets = []
    for voltage_v, rows in groupby(read_sheet_rows(path), key=lambda row: row.voltage_v):
        _, given, thrusts_n, currents_a, rpm = zip(*rows, strict=True)
        commands = [(value - centre) / span for value in given]
        sheets.append(_core.ThrusterSheet(voltage_v, commands, [gain * n for n in thrusts_n], currents_a, rpm))
    try:
        return _core.ThrusterSheets(sheets, shown_name(path))
    except ValueError as error:
        raise ScenarioError(str(error)) from None


def load_thruster(source: str | Path, folder: Path | None = None) -> ThrusterType:
    """Load a type from a packaged name ("t200_16v") or a path, relative to `folder`. Raises ScenarioError."""
    return read_spec(ThrusterType, source, "thrusters", folder)


def _thruster_type(value: object, info: ValidationInfo) -> object:
    return load_thruster(value, (info.context or {}).get("folder")) if isinstance(value, str | Path) else value


def _require_direction(direction: Direction, key: str) -> None:
    if math.hypot(*direction) < 1e-6:
        raise broken("must not have zero length", at=(key,), value=list(direction))


class ThrusterMount(Model):
    """A thruster on a vehicle.

    model: the name of a packaged thruster or the path of its YAML file, which is read into a ThrusterType. position_m:
    position of the propeller in the body frame. axis: the direction of positive thrust, of any length. spin: sense of
    rotation seen from behind, at positive thrust. gain: a factor on the type's thrust, such as for another battery
    voltage; the allocation of efforts takes it into account. force: by default a propeller's; or along the world's
    vertical, upward if positive, in any attitude and medium: `buoyancy`, of an engine that changes the displaced
    volume, or `weight`, of a mass moved from moved_from_m to position_m. Their axis must be [0, 0, 1]; the change of
    inertia is neglected. moved_from_m: where the opposite force acts. time_constant_s: time constant of the thrust's
    lag, by default the type's. ventilates: whether a propeller near the surface draws air, which takes thrust even
    while it is covered (Minsaas et al. 1983); by default thrust is lost with the part of the disc above the water.
    health: the fraction of thrust left by a fault, of which the allocation is not aware.
    """

    time_constant_s: Annotated[float, InRange(0, 60, "s")] | None = None
    model: Annotated[ThrusterType, BeforeValidator(_thruster_type, json_schema_input_type=ThrusterName | ThrusterType)]
    position_m: Point3
    axis: Direction
    spin: Literal["clockwise", "counter-clockwise"] = "clockwise"
    gain: Annotated[float, InRange(0.01, 100)] = 1.0
    force: Literal["buoyancy", "weight"] | None = None
    moved_from_m: Point3 | None = None
    ventilates: bool = False
    health: Annotated[float, InRange(0, 1)] = 1.0

    @model_validator(mode="after")
    def _points_somewhere(self) -> ThrusterMount:
        _require_direction(self.axis, "axis")
        if self.force is not None and not (self.axis[2] > 0.0 and self.axis[0] == self.axis[1] == 0.0):
            raise broken(f"must be [0, 0, 1] for `force: {self.force}`", at=("axis",), value=list(self.axis))
        if (self.force == "weight") != (self.moved_from_m is not None):
            raise broken("must be given for `force: weight`, and for no other", at=("moved_from_m",))
        return self

    @property
    def lag_s(self) -> float:
        """The time constant of the thrust's lag."""
        return self.model.time_constant_s if self.time_constant_s is None else self.time_constant_s


class FinMount(Model):
    """A lifting surface: a fin that turns about its span, or a fixed one (deflection_max_deg 0).

    position_m: the centre of pressure. span: the direction about which it turns, right-handed, perpendicular to x.
    area_m2: the reference area of lift and drag. aspect_ratio: effective, span^2 / area, doubled if the hull mirrors
    the fin. parasitic_drag: the drag coefficient at zero lift. efficiency: Oswald's, for the induced drag.
    stall_angle_deg: angle at which lift is halfway to that of a flat plate; omit it for a surface that does not stall,
    such as a hull. stall_sharpness_deg: width of that transition. deflection_max_deg, rate_max_deg_s: limits of its
    angle and rate. slipstream_of: the thruster in whose jet it may be, as a rudder abaft a propeller is: on the part of
    its span that the jet meets, the water is faster by what the thrust makes it (axial momentum theory).
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
    slipstream_of: Name | None = None

    @model_validator(mode="after")
    def _is_perpendicular(self) -> FinMount:
        _require_direction(self.span, "span")
        if abs(self.span[0]) > 1e-6 * math.hypot(*self.span):
            raise broken("must be perpendicular to x", at=("span",), value=list(self.span))
        return self


Rate = Annotated[float, InRange(0, 100, "1/s")]
Seconds = Annotated[float, InRange(0.001, 100, "s")]


class Loop(Model):
    """The cascaded loops of one axis; position errors are in m or rad.

    position_1_s: reference velocity per unit of position error. velocity_1_s: acceleration per unit of velocity error.
    integral_1_s2: acceleration per unit of the velocity error's integral. acceleration_share: fraction of the measured
    acceleration that is opposed, like added inertia.
    """

    position_1_s: Rate = 1.0
    velocity_1_s: Rate = 3.0
    integral_1_s2: Annotated[float, InRange(0, 1000, "1/s2")] = 1.5
    acceleration_share: Annotated[float, InRange(0, 10)] = 0.0


class TurningLoop(Loop):
    """The cascaded loops of roll, pitch or yaw."""

    position_1_s: Rate = 2.0
    velocity_1_s: Rate = 4.0
    integral_1_s2: Annotated[float, InRange(0, 1000, "1/s2")] = 4.0


class Control(Model):
    """Gains and limits of all loops. An axis without actuators has none.

    surge, sway, heave, roll, pitch, yaw: gains of each axis. filter_s: time constant of the filter of measured
    acceleration. tracking_s: time constant with which a saturated integral follows the actual thrust. speed_min_m_s:
    the speed below which fins do not turn the vehicle; surveys fly no slower. speed_max_m_s, climb_max_m_s,
    turn_max_rad_s: limits on the reference velocities towards a position (horizontal, vertical) and an attitude.
    acceleration_max_m_s2, turn_acceleration_max_rad_s2: limits on the rate of change of the reference velocities.
    """

    surge: Loop = Loop.model_construct()
    sway: Loop = Loop.model_construct()
    heave: Loop = Loop.model_construct()
    roll: TurningLoop = TurningLoop.model_construct()
    pitch: TurningLoop = TurningLoop.model_construct()
    yaw: TurningLoop = TurningLoop.model_construct()
    filter_s: Seconds = 0.2
    tracking_s: Seconds = 1.0
    speed_min_m_s: Annotated[float, InRange(0, 20, "m/s")] = 0.0
    speed_max_m_s: Annotated[float, InRange(0.01, 20, "m/s")] = 1.0
    climb_max_m_s: Annotated[float, InRange(0.01, 20, "m/s")] = 0.4
    turn_max_rad_s: Annotated[float, InRange(0.01, 10, "rad/s")] = 0.5
    acceleration_max_m_s2: Annotated[float, InRange(0.01, 20, "m/s2")] = 0.5
    turn_acceleration_max_rad_s2: Annotated[float, InRange(0.01, 20, "rad/s2")] = 1.0
