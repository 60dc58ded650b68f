"""Long runs that can be stopped at their next pause by Ctrl-C or SIGTERM. SIGTERM also skips deferrable work.

SIGHUP, which a terminal sends when it is closed, is treated as SIGTERM.
"""

from __future__ import annotations

import errno
import io
import os
import signal
import stat
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, TextIO

GRACE_S = 1.0
"""The longest wall time [s] from SIGTERM to a pause; a service manager kills the process soon after."""
_kept = ""


def ending_signals() -> list[signal.Signals]:
    """Return the signals that end a program: SIGHUP only if it is not ignored, as it is under nohup."""
    ending = [signal.SIGINT, signal.SIGTERM]
    return ending if signal.getsignal(signal.SIGHUP) == signal.SIG_IGN else [*ending, signal.SIGHUP]


def leave_closed_terminal() -> None:
    """Discard further output if its terminal was closed: each write to it would raise OSError, and end what is left."""
    for output in (1, 2):
        with suppress(OSError):
            if stat.S_ISCHR(os.fstat(output).st_mode) and not os.isatty(output):
                discarding = os.open(os.devnull, os.O_WRONLY)
                os.dup2(discarding, output)
                os.close(discarding)


class _Output(io.FileIO):
    def write(self, data: Any, /) -> int:
        try:
            return super().write(data)
        except OSError as error:
            if error.errno != errno.EIO:
                raise
        leave_closed_terminal()
        return super().write(data)


def outliving_terminal(stream: TextIO) -> TextIO:
    """Return a stream to the terminal of stdout or stderr that discards what is written after it was closed.

    A write may find it closed before Python runs the handler of its SIGHUP, and would end the flight with an error.
    """
    raw = _Output(stream.fileno(), "w", closefd=False)
    return io.TextIOWrapper(io.BufferedWriter(raw), stream.encoding, stream.errors, line_buffering=True)


def note_kept(text: str) -> None:
    """Set what the line of an interrupted command names as kept, with the option that continues it."""
    global _kept
    _kept = text


def kept() -> str:
    """Return what is kept if the command is interrupted now; empty for nothing."""
    return _kept


class Stoppable:
    """A run that can be ended early.

    in_haste: whether to skip everything that can be done later, such as a report.
    """

    at_once = False
    """True while the first request ends the run at once, by KeyboardInterrupt, since there is nothing to keep."""
    in_haste = False
    heard = False
    """Whether the run has noticed the request and will end."""
    _stop_requested = False

    def stop(self, *, in_haste: bool = False) -> None:
        """End the run at its next pause. May be called from a signal handler."""
        self._stop_requested = True
        self.in_haste = self.in_haste or in_haste

    def stop_requested(self) -> bool:
        """Return whether `stop` was called."""
        self.heard = self.heard or self._stop_requested
        return self._stop_requested


@contextmanager
def stop_on_signals(flight: Stoppable) -> Iterator[None]:
    """During the block, a first Ctrl-C or SIGTERM ends the flight at its next pause, and a second one ends it at once.

    Where the flight is `at_once`, the first one does. After SIGTERM or SIGHUP, work that can be done later is skipped,
    and KeyboardInterrupt is raised if there is no pause within GRACE_S, for example during a long computation. Since
    only the main thread receives signals, this does nothing on other threads.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    terminated = False

    def interrupt(number: int, frame: object) -> None:
        if flight.stop_requested() or flight.at_once:
            raise KeyboardInterrupt
        flight.stop()

    def terminate(number: int, frame: object) -> None:
        nonlocal terminated
        leave_closed_terminal()
        if terminated:
            raise KeyboardInterrupt
        terminated = True
        if flight.at_once:
            raise KeyboardInterrupt
        flight.stop(in_haste=True)
        signal.setitimer(signal.ITIMER_REAL, GRACE_S)

    def grace_is_over(number: int, frame: object) -> None:
        if not flight.heard:
            raise KeyboardInterrupt

    handlers = {number: interrupt if number == signal.SIGINT else terminate for number in ending_signals()}
    handlers[signal.SIGALRM] = grace_is_over
    before = {number: signal.signal(number, handler) for number, handler in handlers.items()}
    try:
        yield
    finally:
        if terminated:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
        for number, handler in before.items():
            signal.signal(number, handler)
