"""A survey in mid-flight, its map apart, as a file: what another process needs to fly on."""

from __future__ import annotations

import base64
import hashlib
import io
import json
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Base64Bytes, BaseModel, ConfigDict, Field, ValidationError

from uwsim.survey.log import SurveyLog
from uwsim.survey.record import PingSample

TITLE = "uwsim survey 1"
Packed = str
"""An array: NumPy's .npy in base64."""


@dataclass
class FlightState:
    """simulation: of Simulator.save_state. mission: of its save, None where it has none. wall_s: flown so far."""

    simulation: bytes
    mission: dict[str, Any] | None
    steps_to_ping: int
    begun_s: float
    wall_s: float
    stage_wall_s: dict[str, float]
    log: SurveyLog


class _Sample(BaseModel):
    model_config = ConfigDict(extra="forbid")
    ranges_m: Packed
    angles_rad: Packed
    world_from_sonar: Packed
    points_world_m: Packed


class _Written(BaseModel):
    """The file's content; the rest of what it holds, of the checkpoint, goes by `more`."""

    model_config = ConfigDict(extra="forbid")
    simulation: Base64Bytes
    mission: dict[str, Any] | None
    steps_to_ping: Annotated[int, Field(ge=1)]
    begun_s: float
    wall_s: Annotated[float, Field(ge=0)]
    stage_wall_s: dict[str, float]
    area_world_m: Packed
    path_world_m: Packed
    echo_count: int
    richest: _Sample | None
    richest_score: float
    more: dict[str, Any]


def to_bytes(state: FlightState, more: dict[str, Any]) -> bytes:
    """The state, and more that JSON knows, under a title with a checksum."""
    log = state.log
    content = {
        "simulation": base64.b64encode(state.simulation).decode(),
        "mission": state.mission,
        "steps_to_ping": state.steps_to_ping,
        "begun_s": state.begun_s,
        "wall_s": state.wall_s,
        "stage_wall_s": state.stage_wall_s,
        "area_world_m": _packed(log.area_world_m),
        "path_world_m": _packed(log.path_world_m),
        "echo_count": log.echo_count,
        "richest": None if log.richest is None else {name: _packed(a) for name, a in vars(log.richest).items()},
        "richest_score": log.richest_score,
        "more": more,
    }
    text = json.dumps(content).encode()
    return f"{TITLE} {hashlib.blake2b(text).hexdigest()}\n".encode() + text


def from_bytes(data: bytes) -> tuple[FlightState, dict[str, Any]]:
    """What to_bytes was given. Raises ValueError when the bytes are damaged, truncated or of another version."""
    title, _, text = data.partition(b"\n")
    if not title.startswith(TITLE.encode() + b" "):
        raise ValueError(f"does not begin with '{TITLE}': another program or version wrote it")
    if title.split(b" ")[-1] != hashlib.blake2b(text).hexdigest().encode():
        raise ValueError("is damaged or truncated: its checksum is not that of its content")
    try:
        read = _Written.model_validate(json.loads(text))
    except ValidationError as error:
        first = error.errors()[0]
        raise ValueError(f"{'.'.join(str(part) for part in first['loc'])}: {first['msg']}") from None
    sample = None if read.richest is None else {name: _unpacked(packed) for name, packed in dict(read.richest).items()}
    log = SurveyLog(
        area_world_m=_unpacked(read.area_world_m),
        positions_world_m=list(_unpacked(read.path_world_m).reshape(-1, 3)),
        echo_count=read.echo_count,
        richest=None if sample is None else PingSample(**sample),
        richest_score=read.richest_score,
    )
    state = FlightState(
        read.simulation, read.mission, read.steps_to_ping, read.begun_s, read.wall_s, read.stage_wall_s, log
    )
    return state, read.more


def _packed(array: NDArray[Any]) -> Packed:
    file = io.BytesIO()
    np.save(file, array, allow_pickle=False)
    return base64.b64encode(file.getvalue()).decode()


def _unpacked(packed: Packed) -> NDArray[Any]:
    try:
        array: NDArray[Any] = np.load(io.BytesIO(base64.b64decode(packed, validate=True)), allow_pickle=False)
    except (ValueError, EOFError, OSError) as error:
        raise ValueError(f"holds an array that is none: {error}") from None
    return array
