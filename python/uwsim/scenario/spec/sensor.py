"""A vehicle's sensor, as read from its YAML file: its kind, mount, rate and errors.

The kinds and their parameters are in the table of uwsim.scenario.spec.sensor_kind; a new kind needs no change here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated

from pydantic import AfterValidator, BeforeValidator, Field, GetJsonSchemaHandler, StrictBool, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema
from pydantic_core.core_schema import ValidationInfo

from uwsim import _core
from uwsim.base.named import did_you_mean
from uwsim.scenario.read.spec_file import read_spec
from uwsim.scenario.spec.fields import AssetName, InRange, Model, Name, Point3, YawPitchRoll, broken
from uwsim.scenario.spec.json_schema import figures, one_of_kinds
from uwsim.scenario.spec.sensor_kind import DerivedKind, checked_values, sensor_kind, sensor_kinds, usable_sensor_kinds

INS = (
    "gyro_bias_deg_h", "gyro_random_walk_deg_sqrt_h", "accelerometer_bias_ug", "accelerometer_noise_ug_sqrt_hz",
    "tilt_std_deg", "heading_std_deg",
)  # fmt: skip

GRADES: Mapping[str, Mapping[str, Mapping[str, float]]] = {
    "ins": {
        "navigation": dict(zip(INS, (0.01, 0.002, 50.0, 10.0, 0.003, 0.05), strict=True)),
        "tactical": dict(zip(INS, (1.0, 0.05, 500.0, 50.0, 0.03, 0.5), strict=True)),
        "mems": dict(zip(INS, (360.0, 2.0, 3000.0, 150.0, 0.2, 2.0), strict=True)),
    },
}
"""The parameters of a kind of sensor by the name that data sheets use for a class of them.

Inertial navigation systems, after El-Sheimy and Youssef 2020, "Inertial sensors technologies for navigation
applications: state of the art and future trends", Satellite Navigation 1:2, table 1, which has a position error of 1
nautical mile per hour and gyroscopes below 0.01 deg/h and 0.002 deg/sqrt(h) for navigation; 10 to 20 nautical miles per
hour and 1 to 10 deg/h, 0.02 to 0.05 deg/sqrt(h) for tactical; 0.1 deg/s and several deg/sqrt(h) for mems, there called
commercial; accelerometers of up to 100 ug for navigation, 1 to 5 mg for the lowest class. Values within these ranges,
and those of accelerometers' noise and alignment, are assumed: an alignment at rest levels to bias / g, and finds north
to the gyroscopes' bias over the horizontal part of the Earth's rotation, 0.01 deg/h / (15 deg/h cos 45 deg) = 0.05 deg;
the others take their heading from elsewhere.
"""


SensorSetName = Annotated[str, AssetName("sensors")]
Magnitude = Annotated[float, InRange(0, 1e9)]
OWN_NOISE = ("scale", "misalignment", "station")
"""Errors of the whole instrument, and of the station's place: they take no noise but their own."""
STATEFUL = ("bias_std", "walk", "instability")  # errors that depend on earlier ones
Limit = Annotated[float, InRange(-1e12, 1e12)]


class Noise(Model):
    """Errors of a sensor, or of one of its channels, in its unit u; zero if left out.

    std [u]: white noise of each sample. density [u/sqrt(Hz)]: white noise as in data sheets; std = density x
    sqrt(rate). turn_on_std [u]: a constant bias, drawn once per run. bias_std [u], bias_time_s: a bias that varies
    about zero, first-order Gauss-Markov. walk [u/sqrt(s)]: a bias that is a random walk from zero. instability [u]:
    flicker noise, called bias instability in data sheets: the flat minimum of the Allan deviation. quantum [u]:
    readings are integer multiples of this value. limits [u]: values at which readings saturate.
    """

    std: Magnitude = 0.0
    density: Magnitude = 0.0
    turn_on_std: Magnitude = 0.0
    bias_std: Magnitude = 0.0
    bias_time_s: Annotated[float, InRange(1e-6, 1e9, "s")] | None = None
    walk: Magnitude = 0.0
    instability: Magnitude = 0.0
    quantum: Magnitude = 0.0
    limits: tuple[Limit, Limit] | None = None

    @model_validator(mode="after")
    def _is_whole(self) -> Noise:
        if self.bias_std > 0 and self.bias_time_s is None:
            raise broken("missing: bias_std needs its correlation time", at=("bias_time_s",))
        if self.limits is not None and self.limits[0] >= self.limits[1]:
            raise broken("must be the lower, then the upper limit", at=("limits",), value=list(self.limits))
        return self


class SensorMount(Model):
    """A sensor of one of the registered kinds, and its mount on the body.

    Rays are cast along the sensor's x: yaw 90 points to port. Parameters of the kind, such as range_max_m, are written
    next to the other keys in YAML, and in `parameters` here. grade: of an ins: navigation, tactical or mems; gives the
    parameters that are not written. position_m: position in the body frame. parameters: in
    Python, the parameters of the kind; in YAML, they are next to the other keys. on: whether it is powered; without
    power it has no readings. rate_hz: sampling rate; every step by default. latency_s: delay from the measurement to
    its arrival. drop_out: the fraction of samples that is lost; a read then returns the last sample that was not lost,
    marked invalid. noise: noise of all channels but scale, misalignment and station, if they have the same unit;
    noise_std: short for noise: {std: ...}. channels: noise by channel, instead of `noise`.
    """

    kind: str
    grade: str | None = None
    on: StrictBool = True
    position_m: Point3 = (0.0, 0.0, 0.0)
    yaw_pitch_roll_deg: YawPitchRoll = (0.0, 0.0, 0.0)
    rate_hz: Annotated[float, InRange(1e-4, 1e5, "Hz")] | None = None
    latency_s: Annotated[float, InRange(0, 60, "s")] = 0.0
    drop_out: Annotated[float, InRange(0, 0.999)] = 0.0
    noise_std: Magnitude | None = None
    noise: Noise | None = None
    channels: dict[str, Noise] = Field(default_factory=dict)
    parameters: dict[str, tuple[float, ...]] = Field(default_factory=dict)

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        schema = super().__get_pydantic_json_schema__(core, handler)
        own = handler.resolve_ref_schema(schema)
        kinds = {}
        for kind in usable_sensor_kinds():
            name = kind.name
            noises = dict.fromkeys(kind.channels, own["properties"]["noise"]["anyOf"][0])
            channels = {"type": "object", "properties": noises, "additionalProperties": False}
            kinds[name] = figures(kind.parameters) | {"description": kind.meaning}
            kinds[name]["properties"]["channels"] = own["properties"]["channels"] | channels
        one_of_kinds(own, kinds, without={"parameters"})
        return schema

    @model_validator(mode="before")
    @classmethod
    def _gathers_parameters(cls, data: object) -> object:
        if not isinstance(data, Mapping) or "kind" not in data:
            return data
        known = sensor_kinds()
        if data["kind"] not in known:
            hint = did_you_mean(str(data["kind"]), known)
            raise broken(f"must be one of {', '.join(known)}{hint}", at=("kind",), value=str(data["kind"]))
        try:
            parameters = sensor_kind(data["kind"]).parameters
        except ValueError as error:  # another package's, which is broken
            raise broken(str(error), at=("kind",), value=str(data["kind"])) from None
        own = {key: value for key, value in data.items() if key not in parameters}
        for key in own:
            if key not in cls.model_fields:
                hint = did_you_mean(str(key), [*cls.model_fields, *parameters])
                raise broken(f"unknown key{hint}", at=(str(key),))
        given = {key: checked_values(key, data[key], parameters[key]) for key in data if key in parameters}
        for key, parameter in parameters.items():
            if math.isnan(parameter.by_default) and key not in {**given, **own.get("parameters", {})}:
                raise broken("missing", at=(key,))
        return {**own, "parameters": {**_of_grade(data), **own.get("parameters", {}), **given}}

    @model_validator(mode="after")
    def _check_channels(self) -> SensorMount:
        kind = sensor_kind(self.kind)
        known = kind.channels
        for name in self.channels:
            if name not in known:
                raise broken(
                    f"must be one of {', '.join(known) or 'none'}{did_you_mean(name, known)}",
                    at=("channels", name),
                    value=name,
                )
        if self.noise is not None and self.noise_std is not None:
            raise broken("give either noise or noise_std", at=("noise_std",), value=self.noise_std)
        for noise in (self.noise, *self.channels.values()) if isinstance(kind, DerivedKind) else ():
            for key in STATEFUL:
                if noise is not None and getattr(noise, key):
                    rule = f"must be 0 for '{self.kind}', whose errors have no memory"
                    at = ("noise",) if noise is self.noise else ("channels",)
                    raise broken(rule, at=(*at, key), value=getattr(noise, key))
        shared = {channel: known[channel][1] for channel in known if channel not in (*self.channels, *OWN_NOISE)}
        if len(set(shared.values())) > 1:
            units = ", ".join(f"{channel} [{unit}]" for channel, unit in shared.items())
            for key in ("noise", "noise_std"):
                if getattr(self, key) not in (None, 0.0, Noise()):
                    raise broken(f"has no single unit: give channels, each with its noise, for {units}", at=(key,))
        return self


def _of_grade(data: Mapping[str, object]) -> dict[str, tuple[float, ...]]:
    """Return the parameters that a mount's grade gives. Raises an error for a grade that its kind does not have."""
    if (grade := data.get("grade")) is None:
        return {}
    known = GRADES.get(str(data["kind"]), {})
    if grade not in known:
        rule = f"must be one of {', '.join(known)}" if known else f"must not be given: '{data['kind']}' has no grades"
        raise broken(rule, at=("grade",), value=str(grade))
    return {name: (value,) for name, value in known[str(grade)].items()}


class SensorSet(Model):
    """Sensors shared by several vehicles, in a separate YAML file.

    sensors: the sensors by name.
    """

    name: Name
    description: str = ""
    sensors: dict[Name, SensorMount]


def load_sensors(source: str | Path, folder: Path | None = None) -> dict[str, SensorMount]:
    """Load a set of sensors from a packaged name ("bluerov2") or a path, relative to `folder`. Raises ScenarioError."""
    return read_spec(SensorSet, source, "sensors", folder).sensors


def _sensors(value: object, info: ValidationInfo) -> object:
    return load_sensors(value, (info.context or {}).get("folder")) if isinstance(value, str | Path) else value


def _named_as_their_kind(sensors: dict[str, SensorMount]) -> dict[str, SensorMount]:
    """Check that sensors named after a kind are of that kind; programs and type checkers rely on this."""
    kinds = _core.sensor_kinds()
    for name, mount in sensors.items():
        if name in kinds and mount.kind != name:
            raise broken(f"must be {name}, as the sensor's name is that kind", at=(name, "kind"), value=mount.kind)
    return sensors


Sensors = Annotated[
    dict[Name, SensorMount],
    BeforeValidator(_sensors, json_schema_input_type=SensorSetName | dict[Name, SensorMount]),
    AfterValidator(_named_as_their_kind),
]
"""Sensors by name, or the packaged name or path of a SensorSet's file."""
