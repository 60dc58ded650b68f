"""Subscriptions: readings taken at a rate in simulated time and handed on."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any

from uwsim.base.agenda import NEVER, next_tick
from uwsim.simulator.simulator import Simulator

logger = logging.getLogger("uwsim.live")


class Subscription:
    """A reading that is taken at all multiples of a period and handed to a sink; see LiveSimulator.every.

    error: the last error of read or sink, and errors: how many there were. They end nothing: the next reading is tried.
    """

    def __init__(
        self,
        simulator: Simulator,
        period_ns: int | None,
        read: Callable[[Simulator], Any],
        sink: Callable[[Any], object],
    ) -> None:
        """period_ns: None: it is read now and after each jump of time alone."""
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
        """Take no more readings. One that is being taken may still arrive."""
        self.cancelled = True
        self._sim.agenda.remove(self)

    def jump(self, tick: int) -> None:
        """Be due at once, as time has jumped."""
        self.due_tick = tick

    def act(self, tick: int) -> None:
        """Read and hand on, then be due at the next multiple of the period; log a new error once."""
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
