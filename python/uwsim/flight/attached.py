"""The attachments of a flight: uwsim's own, and those of other packages, whose errors do not end it."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any, TypeVar

from uwsim.base.agenda import NEVER
from uwsim.base.journal import CommandObserver, Observer
from uwsim.base.sockets import Entry, SocketWarning, blamed, registered
from uwsim.flight.attachment import Attachment, AttachmentOptions, Attachments, Departure
from uwsim.flight.record import FlightRecord

T = TypeVar("T")


def attached(options: Attachments, flight: Departure) -> dict[str, Attachment]:
    """Return the attachments of a flight by name. Raises ValueError.

    Another package's that raises an error costs a warning and takes no further part; the flight goes on.
    """
    known = registered(Attachments.socket)
    if flight.sim.link is not None and "link" not in options.requested:
        raise ValueError(f"link: no installed package provides it (entry point 'link' in {Attachments.socket})")
    for name, each in options.requested.items():
        found = each.attach(flight) if known[name].is_own else _foreign(known[name], each, flight)
        if found is not None:
            flight.others[name] = found
    return flight.others


def _foreign(entry: Entry, options: AttachmentOptions, flight: Departure) -> Attachment | None:
    """Return what another package attaches, with its errors contained."""
    guard = _Guard(entry)
    found: Any = guard.call("attach", lambda: options.attach(flight), None)
    if found is not None and not isinstance(found, Attachment):
        guard.end("attach", TypeError(f"{type(found).__name__}: must be an Attachment or None"))
    return None if guard.has_ended or found is None else _Foreign(guard, found)


class _Guard:
    """Calls what belongs to an entry until it raises an error, which becomes a warning."""

    def __init__(self, entry: Entry) -> None:
        self._entry = entry
        self.has_ended = False

    def call(self, name: str, function: Callable[..., T], default: T, *arguments: Any, closes: bool = False) -> T:
        """Return the function's result, or the default if it raises an error.

        Once anything has raised one, only functions that close what was opened are called.
        """
        if self.has_ended and not closes:
            return default
        try:
            return function(*arguments)
        except (Exception, SystemExit) as error:  # a stranger's code may raise anything
            self.end(name, error)
            return default

    def end(self, name: str, error: BaseException) -> None:
        """Warn of an error in a method of this name, and call nothing more."""
        self.has_ended = True
        what = blamed(Attachments.socket, self._entry, error, name)
        warnings.warn(f"{what}; the flight goes on without it", SocketWarning, stacklevel=2)


class _Foreign(Attachment):
    """Another package's attachment."""

    def __init__(self, guard: _Guard, inner: Attachment) -> None:
        self._guard, self._inner = guard, inner
        self.table = guard.call("table", lambda: inner.table, None)
        on_ping = guard.call("on_ping", lambda: inner.on_ping, None)
        self.on_ping = None if on_ping is None else lambda *ping: guard.call("on_ping", on_ping, None, *ping)

    def start(self) -> None:
        self._guard.call("start", self._inner.start, None)

    @contextmanager
    def flying(self) -> Iterator[None]:
        stack = ExitStack()
        self._guard.call("flying", lambda: stack.enter_context(self._inner.flying()), None)
        try:
            yield
        finally:
            self._guard.call("flying", stack.close, None, closes=True)

    @property
    def observer(self) -> Observer | None:
        found = self._guard.call("observer", lambda: self._inner.observer, None)
        if found is None:
            return None
        return (_ForeignListener if isinstance(found, CommandObserver) else _ForeignObserver)(self._guard, found)

    def ended(self, flown: FlightRecord) -> FlightRecord:
        found = self._guard.call("ended", self._inner.ended, flown, flown)
        if isinstance(found, FlightRecord):
            return found
        self._guard.end("ended", TypeError(f"{type(found).__name__}: must be a FlightRecord"))
        return flown

    def try_close(self) -> OSError | None:
        return self._guard.call("try_close", self._inner.try_close, None, closes=True)


class _ForeignObserver:
    """Another package's observer; never due again once anything of its package has raised an error."""

    def __init__(self, guard: _Guard, inner: Observer) -> None:
        self._guard, self._inner = guard, inner

    @property
    def due_tick(self) -> int:
        return self._guard.call("due_tick", lambda: int(self._inner.due_tick), NEVER)

    def observe(self) -> None:
        self._guard.call("observe", self._inner.observe, None)


class _ForeignListener(_ForeignObserver):
    """Another package's observer that is notified of commands, too."""

    _inner: Any

    def commanded(self, name: str, arguments: dict[str, Any]) -> None:
        self._guard.call("commanded", self._inner.commanded, None, name, arguments)
