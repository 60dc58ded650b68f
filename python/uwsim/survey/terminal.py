"""The terminal output of a survey: progress and messages on stderr, results on stdout; and Ctrl-C during the flight."""

from __future__ import annotations

import importlib.util
import math
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from typing import Protocol

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn


class Stoppable(Protocol):
    """What Ctrl-C ends."""

    def stop(self) -> None:
        """End at the next pause."""

    def stop_requested(self) -> bool:
        """Whether stop was called."""


REDRAW_S = 0.1  # of wall time, between two states of the progress bar


class Terminal:
    """Prints what a survey does and finds."""

    def __init__(self) -> None:
        self._messages = Console(stderr=True)
        self._results = _ResultConsole()

    def status(self, activity: str) -> AbstractContextManager[object]:
        """Show an activity, such as "scoring the map", while the block runs."""
        return self._messages.status(activity)

    def message(self, text: str) -> None:
        """Print a message, unwrapped, on stderr."""
        self._messages.print(text, highlight=False, markup=False, soft_wrap=True)

    def result(self, result: object) -> None:
        """Print text or a table on stdout."""
        self._results.print(result, highlight=False)

    @contextmanager
    def flight(self, scenario_name: str) -> Iterator[Callable[[float, float], None]]:
        """Show a progress bar while the block runs; yields a function of the share flown, 0 to 1, and the time [s]."""
        bar = Progress(
            TextColumn("surveying {task.fields[scenario]}"),
            BarColumn(),
            TextColumn("{task.percentage:3.0f} %"),
            TimeElapsedColumn(),
            TextColumn("[dim]{task.fields[note]}"),
            console=self._messages,
            disable=not _shows_progress(self._messages),
        )
        with bar:
            task = bar.add_task("", total=1.0, scenario=scenario_name, note="")
            shown_s = -math.inf

            def show(share: float, time_s: float) -> None:
                nonlocal shown_s
                if (now_s := time.monotonic()) - shown_s >= REDRAW_S or share >= 1.0:
                    shown_s = now_s
                    bar.update(task, completed=share, note=f"{time_s / 60:.1f} min simulated")

            yield show


def _shows_progress(console: Console) -> bool:
    """Whether a bar can be drawn: on a terminal, or in a notebook with ipywidgets, which rich needs there."""
    return console.is_terminal or (console.is_jupyter and importlib.util.find_spec("ipywidgets") is not None)


class _ResultConsole(Console):
    """Prints to stdout, and nowhere once the reader has gone: `uwsim survey | head` must not prevent the report."""

    def on_broken_pipe(self) -> None:
        """Redirect stdout to nowhere; rich would end the program."""
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())


@contextmanager
def stop_on_ctrl_c(flight: Stoppable) -> Iterator[None]:
    """During the block, let the first Ctrl-C or SIGTERM end the flight at its next pause, and the second end it now.

    Only the main thread hears them: in another one, nothing is changed.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(number: int, frame: object) -> None:
        if flight.stop_requested():
            raise KeyboardInterrupt
        flight.stop()

    before = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
