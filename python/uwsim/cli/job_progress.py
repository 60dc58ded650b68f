"""The progress bar of many jobs, and Ctrl-C meanwhile."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn, TimeRemainingColumn


class JobProgress:
    """How many jobs are finished, on stderr. Ctrl-C stops them."""

    def __init__(self, bar: Progress, task: TaskID, doing: str) -> None:
        self._bar, self._task, self._doing = bar, task, doing
        self._stop = False

    def tell(self, finished: int, failed: int, count: int) -> None:
        """Show that so many of the jobs are finished, and so many of these failed."""
        note = f"[red]{failed:,} failed" if failed else ""
        self._bar.update(self._task, completed=finished, total=count, note=note, activity=self._doing)

    @contextmanager
    def activity(self, activity: str) -> Iterator[None]:
        """Show an activity while the block runs."""
        self._bar.update(self._task, activity=activity)
        yield

    def stop(self) -> None:
        """End early; what is under way is lost."""
        self._stop = True

    def stop_requested(self) -> bool:
        """Whether stop was called."""
        return self._stop


@contextmanager
def job_progress(what: str, doing: str = "flying") -> Iterator[JobProgress]:
    """Show a progress bar while the block runs. what: the jobs, such as "runs"; doing: what is done with them."""
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
    with bar:
        yield JobProgress(bar, bar.add_task("", total=0, note="", activity=""), doing)
