"""Service requests: field validation, and responses that report success or the reason for a failure."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from uwsim.live import LiveSimulator

Request = dict[str, Any]


def answered(act: Callable[[LiveSimulator, Request], object]) -> Callable[[LiveSimulator, Request], Request]:
    """Wrap a function as a service that reports whether it succeeded."""

    def call(live: LiveSimulator, request: Request) -> Request:
        try:
            message = act(live, request)
        except (ValueError, OSError) as error:
            return {"success": False, "message": str(error)}
        return {"success": True, "message": message if isinstance(message, str) else ""}

    return call


def field(request: Request, name: str, kind: type, default: Any) -> Any:
    """Validate and return a field of a request. Raises ValueError."""
    value = request.get(name, default)
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        value = float(value)
    if kind is int and isinstance(value, float) and value.is_integer():
        value = int(value)  # JavaScript has only floats
    if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
        raise ValueError(f"{name} = {value!r}: must be given, as {kind.__name__}")
    return value
