"""Mission states from outside: checked before anything flies by them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from pydantic import ConfigDict, TypeAdapter, ValidationError

State = TypeVar("State")


def checked_state(kind: type[State], saved: Mapping[str, Any]) -> State:
    """A dataclass from its fields. Raises ValueError, in one line, when one is missing, unknown or not what it is."""
    kind.__pydantic_config__ = ConfigDict(extra="forbid", allow_inf_nan=False)  # type: ignore[attr-defined]
    try:
        return TypeAdapter(kind).validate_python(saved)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        raise ValueError(f"mission state: {where}: {first['msg']}") from None
