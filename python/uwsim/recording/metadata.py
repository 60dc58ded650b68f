"""The metadata at the beginning and end of a recording, as validated values of the text in the file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, Json, NonNegativeInt, ValidationError

from uwsim.channels.delivery.pictures import Stream
from uwsim.channels.families.frames import Tf

Metadata = TypeVar("Metadata", bound=BaseModel)


class Start(BaseModel):
    """Metadata at the start of a recording. begun: wall-clock time."""

    model_config = ConfigDict(frozen=True)

    kind: str
    scenario: str
    seed: int
    step_s: Annotated[FiniteFloat, Field(gt=0.0)]
    tick: NonNegativeInt
    origin: Json[Annotated[list[FiniteFloat], Field(min_length=3, max_length=3)]]
    streams: Json[dict[str, Stream]]
    map_is_older: Json[bool]
    truth: Json[bool]
    tf: Tf
    frame_prefix: str
    tf_rate_hz: Annotated[FiniteFloat, Field(gt=0.0)]
    joint_frames: Json[bool]
    through_link: Json[bool]
    on_wall_clock: Json[bool]
    fingerprint: str
    build: str
    begun: str
    notes: Json[dict[str, Any]]


class End(BaseModel):
    """Metadata at the end of a recording that was closed properly. dropped: the number of messages omitted, by channel.

    on_wall_clock: whether the run was ever at wall-clock speed. Unlike the value at the start, this covers the whole
    run.
    """

    model_config = ConfigDict(frozen=True)

    tick: NonNegativeInt
    state: str
    dropped: Json[dict[str, NonNegativeInt]]
    on_wall_clock: Json[bool]
    notes: Json[dict[str, Any]]


def checked(kind: type[Metadata], text: Mapping[str, str]) -> Metadata:
    """Validate metadata and return its values. Raises ValueError for the first invalid value."""
    try:
        return kind.model_validate(text)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        raise ValueError(f"metadata '{where}': {first['msg']}") from None
