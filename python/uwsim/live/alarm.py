"""An alarm of the step loop, which one thread awaits and which Ctrl-C interrupts at any moment."""

from __future__ import annotations

from queue import Empty, SimpleQueue

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
