"""How Ctrl-C and SIGTERM end what takes long: at its next pause; after SIGTERM without what can be done later."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

GRACE_S = 1.0
"""Wall time after SIGTERM in which the next pause must come: a service manager kills soon afterwards."""


class Stoppable:
    """What ends early when it is asked to.

    in_haste: whether to leave out all that can be done later, such as a report.
    """

    in_haste = False
    heard = False
    """Whether it has asked since it was told to stop: it will end by itself."""
    _stop_requested = False

    def stop(self, *, in_haste: bool = False) -> None:
        """End at the next pause. May be called by a signal handler."""
        self._stop_requested = True
        self.in_haste = self.in_haste or in_haste

    def stop_requested(self) -> bool:
        """Whether stop was called."""
        self.heard = self.heard or self._stop_requested
        return self._stop_requested


@contextmanager
def stop_on_signals(flight: Stoppable) -> Iterator[None]:
    """During the block, let the first Ctrl-C or SIGTERM end the flight at its next pause, and the second end it now.

    After SIGTERM it is in haste. If it comes to no pause within GRACE_S, as in a mission that computes for long, it is
    ended by KeyboardInterrupt. Only the main thread hears signals: in another one, nothing is changed.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    terminated = False

    def interrupt(number: int, frame: object) -> None:
        if flight.stop_requested():
            raise KeyboardInterrupt
        flight.stop()

    def terminate(number: int, frame: object) -> None:
        nonlocal terminated
        if terminated:
            raise KeyboardInterrupt
        terminated = True
        flight.stop(in_haste=True)
        signal.setitimer(signal.ITIMER_REAL, GRACE_S)

    def grace_is_over(number: int, frame: object) -> None:
        if not flight.heard:
            raise KeyboardInterrupt

    handlers = {signal.SIGINT: interrupt, signal.SIGTERM: terminate, signal.SIGALRM: grace_is_over}
    before = {number: signal.signal(number, handler) for number, handler in handlers.items()}
    try:
        yield
    finally:
        if terminated:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
        for number, handler in before.items():
            signal.signal(number, handler)
