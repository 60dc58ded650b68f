"""Requests and subscriptions of other threads to the thread that owns the simulator, and the alarm that they await."""

from __future__ import annotations

import logging
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field
from queue import Empty, SimpleQueue
from typing import Any

from uwsim.base.agenda import NEVER, next_tick
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


LOOK_S = 0.5
"""Python can miss a signal that comes just before a thread blocks: Ctrl-C is noticed after this time at the latest."""


class Alarm:
    """Rung once, from another thread, with the error that ended the wait early, if any.

    A Future would do, but a signal's handler that raises while a Future takes its lock leaves the lock taken, and the
    loop, which rings, would wait for it without end.
    """

    def __init__(self) -> None:
        self._rung = SimpleQueue[Exception | None]()

    def ring(self, error: Exception | None = None) -> None:
        """End the wait, which raises the error."""
        self._rung.put(error)

    def wait(self) -> None:
        """Return when it rings; raise the error that it rings with."""
        while True:
            try:
                error = self._rung.get(timeout=LOOK_S)
            except Empty:
                continue
            if error is not None:
                raise error
            return


logger = logging.getLogger("uwsim.live")


class Subscription:
    """A reading that is taken at all multiples of a period and passed to a sink; see LiveSimulator.every.

    error: the last error raised by the reading or the sink. errors: the number of such errors, which do not end the
    subscription.
    """

    def __init__(
        self,
        simulator: Simulator,
        period_ns: int | None,
        read: Callable[[Simulator], Any],
        sink: Callable[[Any], object],
        *,
        leads: bool = False,
    ) -> None:
        """Create a subscription.

        period_ns: None to take readings only now and after each jump in time. leads: whether readings precede others at
        the same tick.
        """
        self.leads = leads
        self.error: Exception | None = None
        self.errors = 0
        self.cancelled = False
        self.due_tick = simulator.tick
        self._sim = simulator
        self._period_ns = period_ns
        self._step_ns = round(simulator.step_s * 1e9)
        self._read = read
        self._sink = sink

    def __repr__(self) -> str:
        period = "by itself" if self._period_ns is None else f"every {1e-9 * self._period_ns:g} s"
        return f"<Subscription {period}{', cancelled' if self.cancelled else ''}>"

    def cancel(self) -> None:
        """Take no more readings. A reading in progress may still arrive."""
        self.cancelled = True
        self._sim.agenda.remove(self)

    def jump(self, tick: int) -> None:
        """Become due immediately, because simulated time has jumped."""
        self.due_tick = tick

    def act(self, tick: int) -> None:
        """Take a reading and pass it to the sink, then become due at the next multiple of the period."""
        if self.cancelled:
            return
        self.due_tick = NEVER if self._period_ns is None else next_tick(tick, self._period_ns, self._step_ns)
        self.take(tick)

    def take(self, tick: int) -> None:
        """Take a reading and pass it to the sink. A repeated error is logged only once."""
        try:
            self._sink(self._read(self._sim))
        except Exception as error:
            self.errors += 1
            if str(error) != str(self.error):
                logger.exception("a reading at tick %d failed", tick)
            self.error = error
