"""The function with which workers run a job, and the result of a finished one."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any

Work = Callable[[Any], dict[str, Any]]
"""A module-level function that runs a job and returns plain values; it must raise only transient errors."""


Show = Callable[[str], AbstractContextManager[object]]
"""Returns a context manager that displays an activity."""

Tell = Callable[[int, int, int], None]
"""Called with the number of finished jobs, failed jobs and jobs in total."""


@dataclass(frozen=True)
class Finished:
    """A finished job. result: None if every attempt failed or killed its worker. why: the reason for a None result."""

    job: int
    result: dict[str, Any] | None
    trials: int = 1
    why: str = ""

    @property
    def error(self) -> str:
        """The reason for a None result, with the number of attempts."""
        return f"{self.why} ({self.trials} trials)"
