"""The exit codes of `uwsim`, and its end by Ctrl-C, SIGTERM or SIGHUP."""

from __future__ import annotations

import os
import signal
import sys
from typing import NoReturn

from uwsim.base.stoppable import ending_signals, kept, leave_closed_terminal

OK, FAILED, USAGE, STUCK, INCOMPLETE, INTERRUPTED = 0, 1, 2, 3, 4, 130

EXIT_CODES = {
    OK: "success",
    FAILED: "an error, or a check that failed: validate, ros doctor, recording diff, map diff --exit-code, "
    "--verify-map, sweep, fleet",
    USAGE: "an unknown command, option or value, a number out of bounds, or an option that would have no effect",
    STUCK: "survey, run: the vehicle was stuck or capsized",
    INCOMPLETE: "survey, run: coverage is below --min-coverage, or a mission without a plan ended early; exercise: "
    "not passed; replay: the recording was cut off",
    INTERRUPTED: "interrupted by Ctrl-C, SIGTERM or SIGHUP; serve and station exit with 0 instead once they "
    "are running",
}
"""The meaning of each code; USAGE is typer's."""


def exit_code_help() -> str:
    """Return the table as text for --help, marked so that its lines are not joined."""
    rows = (f"{code:>5}  {meaning}" for code, meaning in EXIT_CODES.items())
    return "\b\nExit codes:\n" + "\n".join(rows)


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
