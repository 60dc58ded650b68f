"""A vehicle's sensor, as read from its YAML file: what kind, where, how often, and how it errs.

Which kinds there are, and which figures each takes beside the common ones, the native core tells: a new kind there
needs nothing here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, model_validator
from pydantic_core.core_schema import ValidationInfo
from scipy.spatial.transform import Rotation

from uwsim import _core
from uwsim.scenario.document import read_document
from uwsim.scenario.fields import InRange, Model, Name, Point3, YawPitchRoll, broken
from uwsim.scenario.messages import validated
from uwsim.scenario.paths import assets_folder, did_you_mean, find_yaml

Magnitude = Annotated[float, InRange(0, 1e9)]
Limit = Annotated[float, InRange(-1e12, 1e12)]


class Noise(Model):
    """Errors of a sensor, or of one of its channels, in its own unit u; what is left out does not err.

    std [u]: white noise of each sample. density [u/sqrt(Hz)]: white noise as data sheets give it; std = density x
    sqrt(rate). turn_on_std [u]: a constant bias, drawn once a run. bias_std [u], bias_time_s: a bias that wanders about
    zero, first-order Gauss-Markov. walk [u/sqrt(s)]: a bias that walks away from zero. quantum [u]: readings are whole
    multiples of it. limits [u]: readings saturate at them.
    """

    std: Magnitude = 0.0
    density: Magnitude = 0.0
    turn_on_std: Magnitude = 0.0
    bias_std: Magnitude = 0.0
    bias_time_s: Annotated[float, InRange(1e-6, 1e9, "s")] | None = None
    walk: Magnitude = 0.0
    quantum: Magnitude = 0.0
    limits: tuple[Limit, Limit] | None = None

    @model_validator(mode="after")
    def _is_whole(self) -> Noise:
        if self.bias_std > 0 and self.bias_time_s is None:
            raise broken("missing: bias_std needs its correlation time", at=("bias_time_s",))
        if self.limits is not None and self.limits[0] >= self.limits[1]:
            raise broken("must be the lower, then the upper limit", at=("limits",), value=list(self.limits))
        return self

    def core_spec(self) -> _core.NoiseSpec:
        """Return it as the core takes it."""
        low, high = self.limits or (-math.inf, math.inf)
        return _core.NoiseSpec(
            std=self.std,
            density=self.density,
            turn_on_std=self.turn_on_std,
            bias_std=self.bias_std,
            bias_time_s=self.bias_time_s or 0.0,
            walk=self.walk,
            quantum=self.quantum,
            limit_low=low,
            limit_high=high,
        )


class SensorMount(Model):
    """A sensor of one of the core's kinds (see _core.sensor_kinds), and where it sits on the body.

    Rays are cast along the sensor's x: yaw 90 looks to port. Figures of the kind (_core.sensor_kind(...).parameters,
    such as range_max_m) stand beside the others in YAML, and in `parameters` here.
    rate_hz: samples a second; every step by default. latency_s: from a sample to when it can be read. drop_out: the
    share of samples that is lost; a read then gives the last that came through, marked invalid.
    noise: of every channel; noise_std: short for noise: {std: ...}. channels: by name, instead of `noise`.
    """

    kind: str
    position_m: Point3 = (0.0, 0.0, 0.0)
    yaw_pitch_roll_deg: YawPitchRoll = (0.0, 0.0, 0.0)
    rate_hz: Annotated[float, InRange(1e-4, 1e5, "Hz")] | None = None
    latency_s: Annotated[float, InRange(0, 60, "s")] = 0.0
    drop_out: Annotated[float, InRange(0, 0.999)] = 0.0
    noise_std: Magnitude | None = None
    noise: Noise | None = None
    channels: dict[str, Noise] = Field(default_factory=dict)
    parameters: dict[str, tuple[float, ...]] = Field(default_factory=dict)

    @model_validator(mode="before")
    @classmethod
    def _gathers_parameters(cls, data: object) -> object:
        if not isinstance(data, Mapping) or "kind" not in data:
            return data
        known = _core.sensor_kinds()
        if data["kind"] not in known:
            hint = did_you_mean(str(data["kind"]), known)
            raise broken(f"must be one of {', '.join(known)}{hint}", at=("kind",), value=str(data["kind"]))
        taken = _core.sensor_kind(data["kind"]).parameters
        own = {key: value for key, value in data.items() if key not in taken}
        for key in own:
            if key not in cls.model_fields:
                hint = did_you_mean(str(key), [*cls.model_fields, *taken])
                raise broken(f"unknown key{hint}", at=(str(key),))
        given = {key: _checked(key, data[key], taken[key]) for key in data if key in taken}
        for key, parameter in taken.items():
            if math.isnan(parameter.by_default) and key not in {**given, **own.get("parameters", {})}:
                raise broken("missing", at=(key,))
        return {**own, "parameters": {**own.get("parameters", {}), **given}}

    @model_validator(mode="after")
    def _knows_its_channels(self) -> SensorMount:
        known = _core.sensor_kind(self.kind).channels
        for name in self.channels:
            if name not in known:
                raise broken(
                    f"must be one of {', '.join(known) or 'none'}{did_you_mean(name, known)}",
                    at=("channels", name),
                    value=name,
                )
        if self.noise is not None and self.noise_std is not None:
            raise broken("give either noise or noise_std", at=("noise_std",), value=self.noise_std)
        return self

    def core_spec(self, name: str) -> _core.SensorSpec:
        """Return it as the core takes it. Raises ValueError."""
        overall = self.noise or Noise(std=self.noise_std or 0.0)
        return _core.SensorSpec(
            name,
            self.kind,
            self.position_m,
            Rotation.from_euler("ZYX", self.yaw_pitch_roll_deg, degrees=True).as_quat(),
            parameters={key: list(values) for key, values in self.parameters.items()},
            noise={
                channel: self.channels.get(channel, overall).core_spec()
                for channel in _core.sensor_kind(self.kind).channels
            },
            rate_hz=self.rate_hz or 0.0,
            latency_s=self.latency_s,
            drop_out=self.drop_out,
        )


def _checked(key: str, value: Any, parameter: _core.SensorParameter) -> tuple[float, ...]:
    """Return the parameter's values, within its range."""
    several = parameter.width > 1
    values = list(value) if several and isinstance(value, Sequence) and not isinstance(value, str) else [value]
    if several and len(values) != parameter.width:
        raise broken(f"must have {parameter.width} values", at=(key,), value=value)
    for number in values:
        if isinstance(number, bool) or not isinstance(number, int | float):
            raise broken("must be a number", at=(key,), value=number)
        if not parameter.low <= number <= parameter.high:
            rule = f"must be in [{parameter.low:g}, {parameter.high:g}] {parameter.unit}"
            raise broken(rule, at=(key,), value=float(number), unit=parameter.unit)
    return tuple(float(number) for number in values)


class SensorSet(Model):
    """Sensors that several vehicles carry alike, in a YAML file of their own."""

    name: Name
    description: str = ""
    sensors: dict[Name, SensorMount]


def load_sensors(source: str | Path, folder: Path | None = None) -> dict[str, SensorMount]:
    """Load a set from a packaged name ("bluerov2") or a path, relative to `folder`. Raises ScenarioError."""
    beside = (folder or Path()) / source
    path = beside if beside.is_file() else find_yaml(source, "sensors")
    document = read_document(path, path.name if assets_folder() in path.parents else str(path))
    return validated(SensorSet, document.values, document).sensors


def _sensors(value: object, info: ValidationInfo) -> object:
    return load_sensors(value, (info.context or {}).get("folder")) if isinstance(value, str | Path) else value


Sensors = Annotated[dict[Name, SensorMount], BeforeValidator(_sensors)]
"""By name; or the packaged name or the path of a SensorSet's file."""
