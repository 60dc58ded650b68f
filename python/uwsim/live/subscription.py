"""Subscriptions: readings taken at a rate in simulated time and handed on."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any, Protocol

from uwsim.simulator import Simulator

logger = logging.getLogger("uwsim.live")


class Task(Protocol):
    """What the stepping thread does at ticks that it asks for itself.

    due_tick: the next one; after a jump of time it is set to that tick. cancelled: never again.
    """

    due_tick: int
    cancelled: bool

    def deliver(self, sim: Simulator, tick: int) -> None:
        """Do what is due, and be due later. Must be brief."""


class Subscription:
    """A reading that is taken every period and handed to a sink; see LiveSimulator.every.

    error: the last error of read or sink, and errors: how many there were. They end nothing: the next reading is tried.
    """

    def __init__(
        self,
        period_ns: int,
        step_ns: int,
        read: Callable[[Simulator], Any],
        sink: Callable[[Any], object],
        tick: int,
    ) -> None:
        self.error: Exception | None = None
        self.errors = 0
        self.cancelled = False
        self.due_tick = tick
        self._period_ns = period_ns
        self._step_ns = step_ns
        self._read = read
        self._sink = sink

    def cancel(self) -> None:
        """Take no more readings. One that is being taken may still arrive."""
        self.cancelled = True

    def deliver(self, sim: Simulator, tick: int) -> None:
        """Read and hand on, then be due at the next multiple of the period; log a new error once."""
        periods = tick * self._step_ns // self._period_ns + 1
        self.due_tick = -(-periods * self._period_ns // self._step_ns)
        try:
            self._sink(self._read(sim))
        except Exception as error:
            self.errors += 1
            if str(error) != str(self.error):
                logger.exception("a reading at tick %d failed", tick)
            self.error = error
