"""A ledger file of the finished jobs of a plan, with their results, which survives a kill at any time."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

LEDGER = "ledger.jsonl"


class Ledger:
    """A file of JSON lines: the plan on the first line, then the result of one job on each line.

    Each line is flushed to disk before the job counts as finished. `resume` drops a line that was cut off by a kill, so
    each job is either finished or not. If a job has several lines, the last one counts.
    """

    def __init__(self, folder: Path) -> None:
        self.path = folder / LEDGER
        self.results: dict[int, dict[str, Any]] = {}
        self._file: Any = None

    @property
    def exists(self) -> bool:
        """Whether the folder contains a ledger."""
        return self.path.exists()

    def begin(self, plan: Mapping[str, Any]) -> None:
        """Start a new ledger. Raises OSError."""
        self._open("xb")
        self._write({"plan": dict(plan)})

    def resume(self, plan: Mapping[str, Any]) -> None:
        """Read the finished jobs and continue. Raises ValueError if the ledger belongs to another plan, or OSError."""
        found = self.read()
        for key, value in plan.items():
            if found.get(key) != value:
                raise ValueError(f"--resume: '{self.path}': {key} is {value}: was begun with {found.get(key)}")
        self._open("ab")

    def read(self) -> dict[str, Any]:
        """Read the results and return the plan; an incomplete last line is dropped. Raises ValueError or OSError."""
        content = self.path.read_bytes()
        whole = content.rfind(b"\n") + 1
        if whole < len(content):
            os.truncate(self.path, whole)
        lines = content[:whole].splitlines()
        try:
            plan, *results = [json.loads(line) for line in lines]
            self.results = {int(result["job"]): result for result in results}
            return dict(plan["plan"])
        except (ValueError, KeyError, TypeError):
            raise ValueError(f"'{self.path}': is damaged") from None

    def add(self, job: int, result: Mapping[str, Any]) -> None:
        """Record a finished job. Raises OSError."""
        line = {"job": job, **result}
        self._write(line)
        self.results[job] = line

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()
            self._file = None

    def _open(self, mode: str) -> None:
        try:
            self._file = self.path.open(mode, buffering=0)  # otherwise closing would write again, and fail again
        except OSError as error:
            raise OSError(f"'{self.path}': cannot be written: {error.strerror}") from error

    def _write(self, line: Mapping[str, Any]) -> None:
        left, found = json.dumps(line).encode() + b"\n", os.fstat(self._file.fileno())
        if not found.st_nlink:
            raise OSError(f"'{self.path}': was deleted during the run, with all finished results")
        try:
            while left:
                left = left[self._file.write(left) :]
            os.fsync(self._file.fileno())
        except OSError as error:
            os.ftruncate(self._file.fileno(), found.st_size)  # removes the partial line
            raise OSError(f"'{self.path}': cannot be written: {error.strerror}; --resume continues") from error
