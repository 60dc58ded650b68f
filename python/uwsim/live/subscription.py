"""Subscriptions: readings taken at a fixed rate in simulated time and passed to a sink."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any

from uwsim.base.agenda import NEVER, next_tick
from uwsim.simulator.simulator import Simulator

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
