"""Validation of a mission's saved state."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from pydantic import ConfigDict, TypeAdapter, ValidationError

State = TypeVar("State")


def checked_state(kind: type[State], saved: Mapping[str, Any]) -> State:
    """Build a dataclass from its saved fields.

    Raises ValueError, in one line, if a field is missing, unknown or of the wrong type.
    """
    kind.__pydantic_config__ = ConfigDict(extra="forbid", allow_inf_nan=False)  # type: ignore[attr-defined]
    try:
        return TypeAdapter(kind).validate_python(saved)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        raise ValueError(f"mission state: {where}: {first['msg']}") from None
