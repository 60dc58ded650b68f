"""The notes of a saved state: what it keeps beside the core's, as JSON. Checked, since they may be a stranger's."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    Base64Bytes,
    BaseModel,
    ConfigDict,
    Field,
    FiniteFloat,
    NonNegativeInt,
    ValidationError,
)

from uwsim.agenda import NEVER

Tick = Annotated[int, Field(ge=0, le=2 * NEVER)]
Nanoseconds = Annotated[int, Field(ge=0, lt=2**63)]
Pair = tuple[FiniteFloat, FiniteFloat]


class _Kept(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)


class _Fault(_Kept):
    spec: dict[str, Any]
    vehicle: str
    begin_tick: Tick
    end_tick: Tick | None
    count: NonNegativeInt
    began_tick: Tick
    filled_tick: Tick
    water_kg: Annotated[FiniteFloat, Field(ge=0.0)]


class _Distortion(_Kept):
    stuck: dict[str, list[float]] | None
    bias: FiniteFloat
    field: str | None


class _Faults(_Kept):
    faults: dict[str, _Fault]
    sensors: dict[str, _Distortion]


class _Beginning(_Kept):
    x_m: FiniteFloat
    y_m: FiniteFloat
    z_m: FiniteFloat
    yaw_rad: FiniteFloat
    time_s: FiniteFloat


class _Failsafe(_Kept):
    state: Literal["", "hold", "surface", "return", "go_on"]
    cause: Literal["", "silence", "battery", "leak", "thruster", "sensor"]
    heard_tick: Tick
    free_tick: Tick
    was_free: bool
    overridden: list[str]
    began: _Beginning
    pilot: Annotated[list[FiniteFloat], Field(min_length=25, max_length=25)] | None  # Controller.memory
    efforts: Annotated[list[Annotated[float, Field(ge=-1, le=1)]], Field(min_length=6, max_length=6)]
    lit: dict[str, Literal["battery", "leak", "thruster", "sensor"]]
    counts: dict[str, NonNegativeInt]
    last: dict[str, list[float]]
    next_look: Tick
    next_control: Tick


class _Programs(_Kept):
    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, _Failsafe]
    faults: _Faults
    all_stopped: list[str] = []  # of a state of an earlier version: none


class _Event(_Kept):
    tick: Tick
    time_s: FiniteFloat
    vehicle: str
    name: str
    values: dict[str, Any]


class _Figures(_Kept):
    silence_ns: Annotated[int, Field(gt=0, lt=2**63)]
    gravity_m_s2: Annotated[FiniteFloat, Field(gt=0)]
    density_kg_m3: Annotated[FiniteFloat, Field(gt=0)]


class _Estimate(_Kept):
    version: Literal[1, 2] = 1  # of `filter`; 1 has no figures
    figures: _Figures | None = None
    filter: Base64Bytes
    imu_ns: Nanoseconds
    from_ns: dict[str, Nanoseconds]


def _estimate(text: str) -> str:
    _Estimate.model_validate_json(text)
    return text


class _Notes(_Kept):
    lamps: dict[str, dict[str, bool]]
    parameters: dict[str, Any]
    cameras: dict[str, tuple[Nanoseconds, Pair, Pair]]
    estimates: dict[str, Annotated[str, AfterValidator(_estimate)]]
    programs: _Programs
    events: list[_Event]


def read_notes(text: str) -> dict[str, Any]:
    """Return the notes as `Simulator.save_state` wrote them. Raises ValueError with the first that it cannot have."""
    try:
        return _Notes.model_validate_json(text).model_dump()
    except ValidationError as error:
        first = error.errors()[0]
        path = ".".join(str(part) for part in ("state", *first["loc"]))
        raise ValueError(f"{path} = {first['input']!r:.60}: {first['msg']}") from None
