"""Workers: processes that run jobs and return each result as soon as it is available."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from types import TracebackType
from typing import Any, Protocol, Self

from uwsim.base.extras import need_extra
from uwsim.campaigns.workers.work import Finished, Work


class Workers(Protocol):
    """Processes that run jobs; as a context manager, it ends them."""

    count: int
    """The number of jobs that run at the same time."""

    def finished(
        self, work: Work, jobs: Mapping[int, Any], *, retries: int, stop_requested: Callable[[], bool]
    ) -> Iterator[Finished]:
        """Run jobs, given by number; yield each as it finishes.

        retries: how often a job is tried again if its worker died, or it raised OSError or MemoryError. Ends early,
        dropping the jobs in progress, once stop_requested() is true.
        """

    def __enter__(self) -> Self: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...


class ThisProcess:
    """Runs jobs one at a time in this process, for tests and debuggers."""

    count = 1

    def finished(
        self, work: Work, jobs: Mapping[int, Any], *, retries: int, stop_requested: Callable[[], bool]
    ) -> Iterator[Finished]:
        """Run jobs; see Workers."""
        for number, job in jobs.items():
            if stop_requested():
                return
            yield self._tried(work, number, job, retries)

    @staticmethod
    def _tried(work: Work, number: int, job: Any, retries: int) -> Finished:
        why = ""
        for trial in range(retries + 1):
            try:
                return Finished(number, work(job), trial + 1)
            except (OSError, MemoryError) as error:
                why = f"{type(error).__name__}: {error}"
        return Finished(number, None, retries + 1, why)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Do nothing."""


def open_workers(count: int | None = None, *, scheduler: str | None = None) -> Workers:
    """Return workers for use in a `with` statement.

    count: number of processes on this machine (default: one per core); 0 runs jobs in this process. scheduler: the
    address of a Dask cluster, such as tcp://10.0.0.1:8786, whose workers are used instead. Raises ValueError.
    """
    if count is not None and not 0 <= count <= 4096:
        raise ValueError(f"workers = {count}: must be in [0, 4096]")
    if scheduler is not None and count is not None:
        raise ValueError(f"workers = {count}: has no effect with a scheduler, which has its own workers")
    if count == 0:
        return ThisProcess()
    for module in ("distributed", "cryptography"):
        need_extra(module, "work on several processes")
    from uwsim.campaigns.workers.dask_workers import ClusterWorkers, local_workers

    if scheduler is not None:
        return ClusterWorkers.connected(scheduler)
    return local_workers(count or len(os.sched_getaffinity(0)))
