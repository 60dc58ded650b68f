"""Requests from other threads to the thread that owns the simulator."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field
from typing import Any

from uwsim.simulator.simulator import Simulator


class NotRunningError(RuntimeError):
    """Raised if the live simulator has not been started or has stopped."""


@dataclass(eq=False)
class Request:
    """A function to call with the simulator between two steps. The future receives its result or error.

    name, arguments: the entry in the log. If name is None, the function changes nothing and is not logged. is_vital:
    whether to accept the request even if the queue is full. stops: the vehicle that it stops, ahead of all waiting
    requests; releases: the vehicle whose stop it releases.
    """

    function: Callable[[Simulator], Any]
    name: str | None = None
    arguments: dict[str, Any] = field(default_factory=dict)
    future: Future[Any] = field(default_factory=Future)
    is_vital: bool = False
    stops: str | None = None
    releases: str | None = None
