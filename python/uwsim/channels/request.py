"""Service requests: field validation, and responses that report success or the reason for a failure."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from uwsim.base.arguments import is_number
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


def answered_later(
    begin: Callable[[LiveSimulator, Request], Future[Any]],
) -> Callable[[LiveSimulator, Request], Future[Request]]:
    """Wrap a function that begins a command as a service that responds, without blocking, once it has taken effect."""

    def call(live: LiveSimulator, request: Request) -> Future[Request]:
        try:
            order = begin(live, request)
        except (ValueError, OSError) as error:
            order = Future()
            order.set_exception(error)
        return following(order, lambda: answered(lambda live, request: order.result())(live, request))

    return call


def following(first: Future[Any], make: Callable[[], Request]) -> Future[Request]:
    """Return a future of what `make` returns or raises once `first` is done."""
    made: Future[Request] = Future()

    def finish(done: Future[Any]) -> None:
        try:
            made.set_result(make())
        except Exception as error:
            made.set_exception(error)

    first.add_done_callback(finish)
    return made


def field(request: Request, name: str, kind: type, default: Any) -> Any:
    """Validate and return a field of a request. Raises ValueError."""
    value = request.get(name, default)
    if kind is float and is_number(value):
        value = float(value)
    if kind is int and isinstance(value, float) and value.is_integer():
        value = int(value)  # JavaScript has only floats
    if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
        raise ValueError(f"{name} = {value!r:.60}: must be given, as {kind.__name__}")
    return value
