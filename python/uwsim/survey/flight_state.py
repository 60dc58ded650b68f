"""The state of a survey in flight, apart from its maps, as bytes: what another process needs to continue it."""

from __future__ import annotations

import base64
import hashlib
import io
import json
import re
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Base64Bytes, BaseModel, ConfigDict, Field, ValidationError

from uwsim.survey.ping_log import PingLog
from uwsim.survey.record import PingSample

NAME, VERSION = "uwsim survey", 2
"""What a file begins with. To raise the version makes the surveys that users have saved unreadable: give new fields
defaults instead."""
EncodedArray = str
"""An array as NumPy's .npy format in base64."""


@dataclass
class FlightState:
    """A survey in flight.

    simulation: bytes of Simulator.save_state. mission: its saved state, None if it has none. begun_s: simulated time at
    the start of the survey. wall_s: wall time flown so far. ashore: the station's end of the link, if there is one.
    """

    simulation: bytes
    mission: dict[str, Any] | None
    steps_to_ping: int
    begun_s: float
    wall_s: float
    stage_wall_s: dict[str, float]
    log: PingLog
    ashore: dict[str, Any] | None = None


class _SampleFile(BaseModel):
    model_config = ConfigDict(extra="forbid")
    ranges_m: EncodedArray
    angles_rad: EncodedArray
    world_from_sonar: EncodedArray
    points_world_m: EncodedArray


class _StateFile(BaseModel):
    """The content of the file; the names are its keys. more: the checkpoint's own data."""

    model_config = ConfigDict(extra="forbid")
    simulation: Base64Bytes
    mission: dict[str, Any] | None
    steps_to_ping: Annotated[int, Field(ge=1)]
    begun_s: float
    wall_s: Annotated[float, Field(ge=0)]
    stage_wall_s: dict[str, float]
    area_world_m: EncodedArray
    path_world_m: EncodedArray
    position_error_m: EncodedArray
    echo_count: int
    richest: _SampleFile | None
    richest_score: float
    pings_with_warning: dict[str, Annotated[int, Field(ge=0)]]
    ashore: dict[str, Any] | None = None
    more: dict[str, Any]


def to_bytes(state: FlightState, more: dict[str, Any]) -> bytes:
    """Return the state and more JSON data as bytes that begin with a title and a checksum."""
    log = state.log
    content = {
        "simulation": base64.b64encode(state.simulation).decode(),
        "mission": state.mission,
        "steps_to_ping": state.steps_to_ping,
        "begun_s": state.begun_s,
        "wall_s": state.wall_s,
        "stage_wall_s": state.stage_wall_s,
        "area_world_m": _encoded(log.area_world_m),
        "path_world_m": _encoded(log.path_world_m),
        "position_error_m": _encoded(np.array(log.position_error_m)),
        "echo_count": log.echo_count,
        "richest": None if log.sample is None else {name: _encoded(a) for name, a in vars(log.sample).items()},
        "richest_score": log.sample_score,
        "pings_with_warning": log.pings_with_warning,
        "ashore": state.ashore,
        "more": more,
    }
    text = json.dumps(content).encode()
    return f"{NAME} {VERSION} {hashlib.blake2b(text).hexdigest()}\n".encode() + text


def from_bytes(data: bytes) -> tuple[FlightState, dict[str, Any]]:
    """Return the arguments of to_bytes. Raises ValueError when the bytes are damaged or of another version."""
    title, _, text = data.partition(b"\n")
    if not (found := re.match(rb"%b (\d{1,9}) " % NAME.encode(), title)):
        raise ValueError(f"does not begin with '{NAME} {VERSION}': written by another program")
    if int(found[1]) != VERSION:
        raise ValueError(f"is of version {int(found[1])}: this uwsim reads {VERSION}")
    if title.split(b" ")[-1] != hashlib.blake2b(text).hexdigest().encode():
        raise ValueError("is damaged or truncated: its checksum does not match its content")
    try:
        read = _StateFile.model_validate(json.loads(text))
    except ValidationError as error:
        first = error.errors()[0]
        raise ValueError(f"{'.'.join(str(part) for part in first['loc'])}: {first['msg']}") from None
    sample = None if read.richest is None else {name: _decoded(array) for name, array in dict(read.richest).items()}
    log = PingLog(
        area_world_m=_decoded(read.area_world_m),
        positions_world_m=_decoded(read.path_world_m).reshape(-1, 3).tolist(),
        position_error_m=_decoded(read.position_error_m).tolist(),
        echo_count=read.echo_count,
        sample=None if sample is None else PingSample(**sample),
        sample_score=read.richest_score,
        pings_with_warning=read.pings_with_warning,
    )
    state = FlightState(
        read.simulation,
        read.mission,
        read.steps_to_ping,
        read.begun_s,
        read.wall_s,
        read.stage_wall_s,
        log,
        read.ashore,
    )
    return state, read.more


def _encoded(array: NDArray[Any]) -> EncodedArray:
    file = io.BytesIO()
    np.save(file, array, allow_pickle=False)
    return base64.b64encode(file.getvalue()).decode()


def _decoded(encoded: EncodedArray) -> NDArray[Any]:
    try:
        array: NDArray[Any] = np.load(io.BytesIO(base64.b64decode(encoded, validate=True)), allow_pickle=False)
    except Exception as error:  # a damaged header can make numpy raise anything
        raise ValueError(f"holds an invalid array: {error}") from None
    return array
