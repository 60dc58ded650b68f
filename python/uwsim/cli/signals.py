"""The end of the program by Ctrl-C, SIGTERM or SIGHUP."""

from __future__ import annotations

import os
import signal
import sys
from typing import NoReturn

from uwsim.base.stoppable import ending_signals, kept, leave_closed_terminal
from uwsim.cli.exit_codes import INTERRUPTED


def exit_on_signals() -> None:
    """End the process immediately on SIGINT, SIGTERM and SIGHUP.

    Call this before the program's imports. Python's own handler would raise KeyboardInterrupt within them, which could
    be swallowed, leave a module half imported, or leave the lock of all imports held, so that other threads hang.
    """
    for number in ending_signals():
        signal.signal(number, exit_interrupted)


def exit_interrupted(number: int, frame: object) -> NoReturn:
    """End the process immediately, without unfinished files. For use as a signal handler."""
    for module, function in (
        ("uwsim.base.atomic_file", "remove_unfinished"),
        ("uwsim._core", "remove_unfinished_files"),
    ):
        if remove := getattr(sys.modules.get(module), function, None):  # None while the module is being imported
            remove()  # of all threads
    leave_closed_terminal()
    os.write(2, f"uwsim: interrupted{(now := kept()) and '; '}{now}\n".encode())
    os._exit(INTERRUPTED)
