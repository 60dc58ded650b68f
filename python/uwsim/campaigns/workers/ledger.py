"""A ledger file of the finished jobs of a plan, with their results, which survives a kill at any time."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Self

from uwsim.base.texts.json_text import json_value
from uwsim.campaigns.workers.work import Finished

LEDGER = "ledger.jsonl"


class Ledger:
    """A file of JSON lines: the plan on the first line, then the result of one job on each line.

    Each line is flushed to disk before the job counts as finished. `resume` drops a line that was cut off by a kill, so
    each job is either finished or not. If a job has several lines, the last one counts.
    """

    def __init__(self, folder: Path, jobs: str = "jobs") -> None:
        self.path = folder / LEDGER
        self._jobs = jobs
        self.results: dict[int, dict[str, Any]] = {}
        self._file: Any = None
        self._whole = 0  # bytes read of whole lines

    @property
    def exists(self) -> bool:
        """Whether the folder contains a ledger."""
        return self.path.exists()

    @classmethod
    @contextmanager
    def opened(cls, folder: Path, plan: Mapping[str, Any], *, resume: bool, what: str, jobs: str) -> Iterator[Self]:
        """Begin or resume a ledger for the duration of the block.

        what, jobs: names of the plan and of its jobs in messages, such as "sweep" and "runs". Raises ValueError if the
        folder's ledger must be resumed, or there is none to resume; otherwise see `begin` and `resume`.
        """
        ledger = cls(folder, jobs)
        if not resume and ledger.exists:
            ledger.read()
            rule = f"holds a {what} already, {len(ledger.results):,} {jobs} of it finished: --resume, or another --out"
            raise ValueError(f"--out {folder}: {rule}")
        if resume and not ledger.exists:
            raise ValueError(f"--resume: there is no {what} to resume in '{folder}'")
        try:
            ledger.resume(plan) if resume else ledger.begin(plan)
            yield ledger
        finally:
            ledger.close()

    def lacks(self, job: int, *, retry_failed: bool = False) -> bool:
        """Return whether a job must be run. retry_failed: also if it has failed."""
        return job not in self.results or (retry_failed and bool(self.results[job]["error"]))

    def result_of(self, finished: Finished) -> dict[str, Any]:
        """Return the result of a job. Raises OSError for one that has none."""
        if finished.result is None:
            raise OSError(f"{self._jobs.removesuffix('s')} {finished.job}: {finished.why}; --resume continues")
        return finished.result

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
        self._file.truncate(self._whole)  # only now, since before, it may have been another program's file

    def read(self) -> dict[str, Any]:
        """Read the results and return the plan, without an incomplete last line. Raises ValueError or OSError."""
        content = self.path.read_bytes()
        self._whole = content.rfind(b"\n") + 1
        lines = content[: self._whole].splitlines()
        try:
            plan, *results = [json_value(line, f"line {k}") for k, line in enumerate(lines, start=1)]
            self.results = {int(result["job"]): result for result in results}
            return dict(plan["plan"])
        except (ValueError, KeyError, TypeError, OverflowError):
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
