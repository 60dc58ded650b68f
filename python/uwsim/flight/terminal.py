"""Terminal output of a flight: progress and messages on stderr, results on stdout."""

from __future__ import annotations

import html
import math
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

Show = Callable[[float | None, float], None]
"""A function that shows the share flown, 0 to 1 or None if unknown, at a simulated time [s]."""
REDRAW_S = 0.1  # wall time between updates of the progress bar


class Silent:
    """Shows nothing; the base class of all flight displays."""

    handles_signals = False
    """Whether Ctrl-C and SIGTERM end the displayed flight and keep its results so far."""

    def status(self, activity: str) -> AbstractContextManager[object]:
        """Show an activity, such as "scoring the map", while the block runs."""
        return nullcontext()

    def message(self, text: str) -> None:
        """Print a message, unwrapped, on stderr."""

    def result(self, result: object) -> None:
        """Print text or a table on stdout."""

    @contextmanager
    def flight(self, activity: str) -> Iterator[Show | None]:
        """Yield a function that shows progress while the block runs, or None if nothing is shown."""
        yield None


class Terminal(Silent):
    """Prints the progress and the results of a flight."""

    handles_signals = True

    def __init__(self) -> None:
        self._messages = Console(stderr=True)
        self._results = _ResultConsole()

    def status(self, activity: str) -> AbstractContextManager[object]:
        """Show an activity, such as "scoring the map", while the block runs."""
        return nullcontext() if self._messages.is_jupyter else self._messages.status(activity)

    def message(self, text: str) -> None:
        """Print a message, unwrapped, on stderr."""
        self._messages.print(text, highlight=False, markup=False, soft_wrap=True)

    def result(self, result: object) -> None:
        """Print text or a table on stdout."""
        self._results.print(result, highlight=False)

    @contextmanager
    def flight(self, activity: str) -> Iterator[Show]:
        """Show a progress bar while the block runs."""
        if self._messages.is_jupyter:
            with _at_most_each(REDRAW_S, _notebook_bar(activity)) as show:
                yield show
            return
        bar = Progress(
            TextColumn("{task.fields[activity]}"),
            BarColumn(),
            TextColumn("{task.fields[percent]}"),
            TimeElapsedColumn(),
            TextColumn("[dim]{task.fields[note]}"),
            console=self._messages,
            disable=not self._messages.is_terminal,
        )
        task = bar.add_task("", total=None, activity=activity, percent="", note="")

        def draw(share: float | None, time_s: float) -> None:
            bar.update(task, note=f"{time_s / 60:.1f} min simulated")
            if share is not None:
                bar.update(task, total=1.0, completed=share, percent=f"{100 * share:3.0f} %")

        with bar, _at_most_each(REDRAW_S, draw) as show:
            yield show


@contextmanager
def _at_most_each(period_s: float, draw: Show) -> Iterator[Show]:
    """Yield a function that calls `draw` at most once per period of wall time.

    On exit, `draw` is called with the last arguments if they have not been drawn yet.
    """
    drawn_s = -math.inf
    last: tuple[float | None, float] | None = None

    def draw_if_due(share: float | None, time_s: float) -> None:
        nonlocal drawn_s, last
        last = share, time_s
        if (now_s := time.monotonic()) - drawn_s >= period_s:
            drawn_s, last = now_s, None
            draw(share, time_s)

    yield draw_if_due
    if last:
        draw(*last)


def _notebook_bar(activity: str) -> Show:
    """Return a function that shows a progress bar in a notebook; rich's own bar would need ipywidgets."""
    from IPython.display import DisplayHandle

    bar: Any = DisplayHandle()  # type: ignore[no-untyped-call]
    show = bar.display

    def draw(share: float | None, time_s: float) -> None:
        nonlocal show
        note = ("" if share is None else f"{100 * share:.0f} %, ") + f"{time_s / 60:.1f} min simulated"
        drawing = "<progress></progress>" if share is None else f"<progress max='1' value='{share:.3f}'></progress>"
        show(
            {"text/plain": f"{activity}: {note}", "text/html": f"{html.escape(activity)} {drawing} {note}"},
            raw=True,
        )
        show = bar.update

    return draw


class _ResultConsole(Console):
    """Prints to stdout until its reader exits: `uwsim survey | head` must still write the report."""

    def on_broken_pipe(self) -> None:
        """Redirect stdout to /dev/null instead of exiting, as rich does."""
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
