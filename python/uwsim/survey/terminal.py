"""The terminal output of a survey: progress and messages on stderr, results on stdout."""

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

Show = Callable[[float, float], None]
"""Shows the share flown, 0 to 1, at a simulated time [s]."""
REDRAW_S = 0.1  # of wall time, between two states of the progress bar


class Terminal:
    """Prints what a survey does and finds."""

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
    def flight(self, scenario_name: str) -> Iterator[Show]:
        """Show a progress bar while the block runs; yields a function of the share flown, 0 to 1, and the time [s]."""
        if self._messages.is_jupyter:
            with _at_most_each(REDRAW_S, _notebook_bar(scenario_name)) as show:
                yield show
            return
        bar = Progress(
            TextColumn("surveying {task.fields[scenario]}"),
            BarColumn(),
            TextColumn("{task.percentage:3.0f} %"),
            TimeElapsedColumn(),
            TextColumn("[dim]{task.fields[note]}"),
            console=self._messages,
            disable=not self._messages.is_terminal,
        )
        task = bar.add_task("", total=1.0, scenario=scenario_name, note="")

        def draw(share: float, time_s: float) -> None:
            bar.update(task, completed=share, note=f"{time_s / 60:.1f} min simulated")

        with bar, _at_most_each(REDRAW_S, draw) as show:
            yield show


@contextmanager
def _at_most_each(period_s: float, draw: Show) -> Iterator[Show]:
    """Yield the function, called at most once in a period of wall time, and with the last arguments in the end."""
    drawn_s = -math.inf
    last: tuple[float, float] | None = None

    def draw_if_due(share: float, time_s: float) -> None:
        nonlocal drawn_s, last
        last = share, time_s
        if (now_s := time.monotonic()) - drawn_s >= period_s:
            drawn_s, last = now_s, None
            draw(share, time_s)

    yield draw_if_due
    if last:
        draw(*last)


def _notebook_bar(scenario_name: str) -> Show:
    """Display a bar in a notebook; rich's bar would need ipywidgets there."""
    from IPython.display import DisplayHandle

    bar: Any = DisplayHandle()  # type: ignore[no-untyped-call]
    show = bar.display

    def draw(share: float, time_s: float) -> None:
        nonlocal show
        note = f"{100 * share:.0f} %, {time_s / 60:.1f} min simulated"
        drawing = f"<progress max='1' value='{share:.3f}'></progress>"
        show(
            {
                "text/plain": f"surveying {scenario_name}: {note}",
                "text/html": f"surveying {html.escape(scenario_name)} {drawing} {note}",
            },
            raw=True,
        )
        show = bar.update

    return draw


class _ResultConsole(Console):
    """Prints to stdout, and nowhere once the reader has gone: `uwsim survey | head` must not prevent the report."""

    def on_broken_pipe(self) -> None:
        """Redirect stdout to nowhere; rich would end the program."""
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
