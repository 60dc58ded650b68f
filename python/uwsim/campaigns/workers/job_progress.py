"""A progress bar for many jobs, and the handling of Ctrl-C."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from uwsim.base.stoppable import Stoppable, note_kept, stop_on_signals


class JobProgress(Stoppable):
    """A progress bar for jobs on stderr. Ctrl-C stops the jobs; SIGTERM or a second Ctrl-C does so immediately."""

    def __init__(self, bar: Progress, task: TaskID, doing: str) -> None:
        self._bar, self._task, self._doing = bar, task, doing

    def tell(self, finished: int, failed: int, count: int) -> None:
        """Show the number of finished and failed jobs."""
        note_kept("finished jobs are kept: --resume continues")
        note = f"[red]{failed:,} failed" if failed else ""
        self._bar.update(self._task, completed=finished, total=count, note=note, activity=self._doing)

    @contextmanager
    def activity(self, activity: str) -> Iterator[None]:
        """Show an activity for the duration of the block."""
        self._bar.update(self._task, activity=activity)
        yield

    @contextmanager
    def abandonable(self, activity: str) -> Iterator[None]:
        """Show an activity that a first Ctrl-C ends at once, since it has nothing to keep, until it is finished."""
        self.at_once = True
        try:
            with self.activity(activity):
                yield
        finally:
            self.at_once = False

    @property
    def arguments(self) -> dict[str, Any]:
        """The keywords with which the functions that run a campaign show it, and stop it."""
        return {"stop_requested": self.stop_requested, "tell": self.tell, "show": self.activity}

    def stop(self, *, in_haste: bool = False) -> None:
        """Stop early; jobs in progress are lost. in_haste: stop immediately, since finished jobs are on disk."""
        super().stop(in_haste=in_haste)
        if in_haste:
            raise KeyboardInterrupt


@contextmanager
def job_progress(what: str, doing: str = "flying") -> Iterator[JobProgress]:
    """Show a progress bar, and stop on signals, for the duration of the block.

    what: the jobs, such as "runs". doing: the activity.
    """
    console = Console(stderr=True)
    bar = Progress(
        TextColumn("{task.fields[activity]}"),
        BarColumn(),
        TextColumn("{task.completed:,.0f} of {task.total:,.0f} " + what),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[note]}"),
        console=console,
        disable=not console.is_terminal,
    )
    progress = JobProgress(bar, bar.add_task("", total=0, note="", activity=""), doing)
    with bar, stop_on_signals(progress):
        yield progress
