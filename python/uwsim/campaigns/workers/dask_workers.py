"""Workers from Dask's `distributed`: processes on this machine, or on any cluster with a scheduler."""

from __future__ import annotations

import contextlib
import logging
import os
import queue
import shutil
import signal
import tempfile
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from multiprocessing import resource_tracker
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import dask
import distributed
from distributed.utils import LoopRunner

from uwsim.base.folder_lock import LOCK, alone_in
from uwsim.campaigns.workers.work import Finished, Work
from uwsim.scenario.fingerprint import build_fingerprint

AHEAD = 2
"""The number of jobs queued at each worker, so that no worker is idle."""
CONNECT_S, POLL_S = 10.0, 0.2
WORKERLESS_S = 300.0
"""The longest time without any worker: after a death, one restarts in seconds, on a busy machine in a minute."""
PROCESSLESS_S = 20.0
"""The longest time without even a process of a local worker: one that dies as it restarts is not started again."""
NO_WORKERS = "all workers have died, and none has come back; --resume continues"
LOCALHOST = "127.0.0.1"
SCRATCH = "uwsim-dask-"
SETTINGS = {
    "distributed.scheduler.allowed-failures": 0,  # trials are counted here
    "distributed.deploy.lost-worker-timeout": "1d",  # the default gives up on workers that take 15 s to restart
    "distributed.admin.tick.limit": "1h",  # a step may hold Python's lock for longer than 3 s
    "distributed.scheduler.http.routes": [],  # status pages, which any site could read
    "distributed.worker.http.routes": [],
    "distributed.worker.profile.enabled": False,  # the profiler samples every thread a hundred times a second
}


class ClusterWorkers:
    """Workers on a Dask cluster. Each must have the same build of uwsim, and access to the files that jobs name."""

    def __init__(
        self, client: distributed.Client, closers: contextlib.ExitStack, own: distributed.LocalCluster | None = None
    ) -> None:
        self._client, self._closers, self._own = client, closers, own
        self.count = sum(client.nthreads().values())
        self._seen_s = self._process_s = time.monotonic()  # when workers, or their processes, were last seen
        self._has_dropped = False
        if not self.count:
            raise ValueError("the scheduler has no workers")
        self._require_same_build()

    @classmethod
    def connected(cls, address: str) -> Self:
        """Connect to a running cluster. Raises ValueError."""
        closers = contextlib.ExitStack()
        try:
            client = closers.enter_context(_connected_client(address))
            return cls(client, closers)
        except BaseException:
            closers.close()
            raise

    def finished(
        self, work: Work, jobs: Mapping[int, Any], *, retries: int, stop_requested: Callable[[], bool]
    ) -> Iterator[Finished]:
        """Run jobs; see Workers."""
        done: queue.SimpleQueue[tuple[int, distributed.Future]] = queue.SimpleQueue()
        waiting, under_way, trials = deque(jobs), dict[int, distributed.Future](), _Trials(retries)

        def begin(number: int) -> None:
            under_way[number] = future = self._client.submit(work, jobs[number], pure=False)
            future.add_done_callback(lambda of: done.put((number, of)))

        try:
            while (waiting or under_way) and not stop_requested():
                at_once = self._alive() if trials.suspects else AHEAD * self.count
                while waiting and len(under_way) < at_once:
                    begin(waiting.popleft())
                try:
                    number, future = done.get(timeout=POLL_S)
                except queue.Empty:
                    self._require_scheduler()
                    self._require_workers()
                    continue
                del under_way[number]
                if (finished := trials.judged(number, future)) is None:
                    waiting.appendleft(number)
                else:
                    yield finished
        finally:
            self._has_dropped = self._has_dropped or bool(under_way) or stop_requested()
            if under_way:
                with contextlib.suppress(Exception):
                    self._client.cancel(list(under_way.values()))

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Disconnect from the cluster. Shut a local one down, immediately if its jobs are no longer waited for."""
        if not self._has_dropped and (kind is None or issubclass(kind, Exception)):
            self._closers.close()
            return
        self._kill()
        with contextlib.suppress(Exception):  # Dask reports workers that are gone
            self._closers.close()

    def _kill(self) -> None:
        """Kill the local workers, since closing the cluster would wait for their queued jobs."""
        for nanny in self._own.workers.values() if self._own is not None else ():
            nanny.auto_restart = False
            if nanny.pid:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(nanny.pid, signal.SIGKILL)

    def _alive(self) -> int:
        """Return the current number of workers, excluding any that are being restarted."""
        return max(1, int(sum(self._client.nthreads().values())))

    def _require_scheduler(self) -> None:
        if self._client.status not in ("running", "connecting"):
            raise OSError("the connection to the scheduler was lost; --resume continues")

    def _require_workers(self) -> None:
        """Raise OSError if there have been no workers for too long, for example because each dies as it starts."""
        now_s = time.monotonic()
        has_workers = bool(self._client.nthreads())
        if has_workers:
            self._seen_s = now_s
        if has_workers or self._own is None or any(nanny.pid for nanny in self._own.workers.values()):
            self._process_s = now_s
        if now_s - self._seen_s > WORKERLESS_S or now_s - self._process_s > PROCESSLESS_S:
            raise OSError(NO_WORKERS)

    def _require_same_build(self) -> None:
        ours = build_fingerprint()
        for address, theirs in self._client.run(build_fingerprint, on_error="return").items():
            if theirs != ours:
                raise ValueError(f"worker {address}: has a different build of uwsim: {theirs}, here {ours}")


class _Trials:
    """Counts the attempts at each job.

    When a worker dies, Dask reports all jobs queued there, since it cannot know which of them was the cause. These jobs
    are suspects: until they are finished, each worker runs only one job at a time, and suspects get one attempt more
    than other jobs.
    """

    def __init__(self, retries: int) -> None:
        self._retries = retries
        self._failed: dict[int, int] = {}
        self.suspects: set[int] = set()

    def judged(self, number: int, future: distributed.Future) -> Finished | None:
        """Return the finished job, or None if it must be tried again. Re-raises errors that jobs must not raise."""
        failed = self._failed.get(number, 0)
        if future.status == "finished":
            self.suspects.discard(number)
            try:
                return Finished(number, future.result(WORKERLESS_S), failed + 1)  # waits if the worker has just died
            except TimeoutError:
                raise OSError(NO_WORKERS) from None
        if future.status in ("pending", "lost"):  # the result was lost with another worker before it was fetched
            return None
        if future.status != "error":
            raise OSError("the scheduler has lost its jobs; --resume continues")
        error = future.exception()
        if isinstance(error, distributed.KilledWorker):
            self.suspects.add(number)
        elif not isinstance(error, OSError | MemoryError):
            raise error
        self._failed[number] = failed + 1
        if failed < self._retries + (number in self.suspects):
            return None
        why = "its worker died" if number in self.suspects else f"{type(error).__name__}: {error}"
        self.suspects.discard(number)
        return Finished(number, None, failed + 1, why)


def local_workers(count: int) -> ClusterWorkers:
    """Start worker processes on this machine that listen on 127.0.0.1, to this process alone. Raises OSError."""
    closers = contextlib.ExitStack()
    try:
        closers.enter_context(dask.config.set(SETTINGS))
        scratch = closers.enter_context(scratch_folder())
        loop = closers.enter_context(_loop_without_signals())
        cluster = distributed.LocalCluster(
            n_workers=count,
            threads_per_worker=1,
            processes=True,
            host=LOCALHOST,
            dashboard_address=f"{LOCALHOST}:0",  # for its health page; by default Dask takes port 8787
            scheduler_kwargs={"dashboard": False},
            preload=["uwsim.campaigns.workers.ignore_ctrl_c"],
            memory_limit=0,
            silence_logs=logging.CRITICAL,
            local_directory=scratch,
            loop=loop,
            security=distributed.Security.temporary(),  # otherwise, any user of this machine could run programs here
        )
        closers.callback(cluster.close, timeout=CONNECT_S)
        client = closers.enter_context(distributed.Client(cluster, set_as_default=False))
        return ClusterWorkers(client, closers, cluster)
    except RuntimeError as error:  # of Dask, whatever the reason
        closers.close()
        raise OSError(f"the workers could not be started: {_root_of(error)}") from error
    except BaseException:
        closers.close()
        raise


def _root_of(error: BaseException) -> str:
    """Return the text of the error from which others followed."""
    while (cause := error.__cause__ or error.__context__) is not None:
        error = cause
    return " ".join(str(error).split()) or type(error).__name__


@contextlib.contextmanager
def _loop_without_signals() -> Iterator[Any]:
    """Run Dask's loop in a thread that blocks Ctrl-C and hang-ups, as do the processes that are started from it.

    A terminal sends both to all its processes, and one that is just starting would print a traceback, or die.
    """
    resource_tracker.ensure_running()  # it unblocks Ctrl-C in the thread that starts it
    runner = LoopRunner()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGHUP})
    try:
        runner.start()
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    try:
        yield runner.loop
    finally:
        runner.stop()


@contextlib.contextmanager
def scratch_folder() -> Iterator[str]:
    """Create a folder for a cluster's files, and remove the folders of clusters that were killed."""
    for left in Path(tempfile.gettempdir()).glob(f"{SCRATCH}*"):
        if (left / LOCK).exists():
            with contextlib.suppress(OSError), alone_in(left):  # in use, or owned by another user
                shutil.rmtree(left, ignore_errors=True)
    with tempfile.TemporaryDirectory(prefix=SCRATCH, ignore_cleanup_errors=True) as folder, alone_in(Path(folder)):
        yield folder


def _connected_client(address: str) -> distributed.Client:
    for name in ("distributed", "distributed.client"):  # Dask sets a separate level for the second
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        return distributed.Client(address, timeout=CONNECT_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise ValueError(f"--scheduler {address}: does not answer: {error}") from error
