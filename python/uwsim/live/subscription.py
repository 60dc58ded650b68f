"""Subscriptions: readings taken at a rate in simulated time and passed on."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any

from uwsim.base.agenda import NEVER, next_tick
from uwsim.simulator.simulator import Simulator

logger = logging.getLogger("uwsim.live")


class Subscription:
    """A reading that is taken at all multiples of a period and passed to a sink; see LiveSimulator.every.

    error: the last error of read or sink; errors: their number. Errors do not end the subscription.
    """

    def __init__(
        self,
        simulator: Simulator,
        period_ns: int | None,
        read: Callable[[Simulator], Any],
        sink: Callable[[Any], object],
    ) -> None:
        """period_ns: None: read only now and after each jump of time."""
        self.error: Exception | None = None
        self.errors = 0
        self.cancelled = False
        self.due_tick = simulator.tick
        self._sim = simulator
        self._period_ns = period_ns
        self._step_ns = round(simulator.step_s * 1e9)
        self._read = read
        self._sink = sink

    def cancel(self) -> None:
        """Take no more readings. One that is under way may still arrive."""
        self.cancelled = True
        self._sim.agenda.remove(self)

    def jump(self, tick: int) -> None:
        """Become due at once, since time has jumped."""
        self.due_tick = tick

    def act(self, tick: int) -> None:
        """Read and pass on, then be due at the next multiple of the period; log a new error once."""
        if self.cancelled:
            return
        self.due_tick = NEVER if self._period_ns is None else next_tick(tick, self._period_ns, self._step_ns)
        try:
            self._sink(self._read(self._sim))
        except Exception as error:
            self.errors += 1
            if str(error) != str(self.error):
                logger.exception("a reading at tick %d failed", tick)
            self.error = error
