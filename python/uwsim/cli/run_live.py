"""Helpers for commands that run a live simulator: waiting for Ctrl-C, and reporting when the pace is not kept."""

from __future__ import annotations

import gc
import signal
import sys
from collections.abc import Callable
from queue import Empty, SimpleQueue

import typer

from uwsim.base.stoppable import ending_signals, leave_closed_terminal
from uwsim.live import LiveSimulator

LOOK_S = 5.0
SLIP_S = 0.5  # wall time slipped within LOOK_S that is worth reporting
SWITCH_S = 0.0005


def run_until_interrupted(live: LiveSimulator, greeting: str, *, ends_with_error: bool = False) -> None:
    """Print the greeting; return on Ctrl-C, SIGTERM or SIGHUP.

    Meanwhile, report on stderr when the simulation slips or fails. ends_with_error: raise the error of a simulation
    that fails instead.
    """
    is_interrupted = _interrupt()
    typer.echo(f"{greeting}: {_how_it_runs(live)}; Ctrl-C ends it")
    slipped_s, error = live.slipped_s, None
    while not is_interrupted(LOOK_S):
        if ends_with_error and live.error is not None:
            raise live.error
        if live.error is not None and live.error is not error:
            typer.echo(f"uwsim: error: the simulation stopped: {live.error}", err=True)
        error = live.error
        if live.slipped_s - slipped_s > SLIP_S:
            typer.echo(
                f"uwsim: warning: the pace is not held: {live.factor:.2f} of {live.speed}, "
                f"{live.slipped_s - slipped_s:.1f} s late in the last {LOOK_S:g} s",
                err=True,
            )
        slipped_s = live.slipped_s


def wait_for_interrupt(greeting: str) -> None:
    """Print the greeting; return on Ctrl-C, SIGTERM or SIGHUP."""
    is_interrupted = _interrupt()
    typer.echo(greeting)
    while not is_interrupted(LOOK_S):
        pass


def keep_threads_moving() -> None:
    """Set up a server process so that no thread blocks the interpreter for a whole step.

    By default, a busy Python thread blocks it for 5 ms, and a full garbage collection for 60 ms, mostly for modules and
    classes that live as long as the process: these are excluded from later collections.
    """
    sys.setswitchinterval(SWITCH_S)
    gc.collect()
    gc.freeze()


def _interrupt() -> Callable[[float], bool]:
    """Return a function that waits so many seconds for a signal that ends the program, and returns whether one came."""
    keep_threads_moving()
    signals: SimpleQueue[int] = SimpleQueue()  # a handler may put while the same thread waits; an Event could deadlock

    def note(number: int, _: object) -> None:
        leave_closed_terminal()
        signals.put(number)

    for number in ending_signals():
        signal.signal(number, note)

    def is_interrupted(wait_s: float) -> bool:
        try:
            signals.get(timeout=wait_s)
        except Empty:
            return False
        return True

    return is_interrupted


def _how_it_runs(live: LiveSimulator) -> str:
    if live.paused:
        return "paused"
    return "as fast as it can" if live.speed == "max" else f"{live.speed:g} times real time"
