"""Inserts scans into a map, in order and in batches; with several threads, in parallel with the simulation."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from uwsim.base.wall_timer import WallTimer
from uwsim.mapping.occupancy_map import OccupancyMap

MAPPING, VERIFICATION, WAITING = "map", "verification", "waiting for the map"
"""Names of the stages of wall time; WAITING is the inserting thread's."""
SCANS_PER_BATCH = 16  # inserting several scans together is faster than one by one, and threads synchronise less often
BACKLOG_S, BATCHES_MIN, BATCHES_MAX = 1.0, 4, 512
"""Limits of the map thread's queue: work for BACKLOG_S seconds, within BATCHES_MIN to BATCHES_MAX batches.

A save takes about a second, during which the queue fills; Ctrl-C waits until the queue is empty.
"""

Scan = tuple[NDArray[np.float32], NDArray[np.float64]]
"""A scan: points in the world (n, 3), and the sonar's position (3,)."""


class MapFiller:
    """Inserts scans into a map. A context manager; on exit, it waits until the map is filled.

    Scans are inserted in order, so the map's bytes do not depend on the number of threads. reference: a second map for
    comparison, into which every scan is inserted individually. on_mapped: called on the map thread with the points (n,
    3) last inserted, if no other scans are waiting; never called with a single thread.
    """

    def __init__(
        self,
        occupancy: OccupancyMap,
        max_range_m: float,
        *,
        threads: int = 1,
        timer: WallTimer | None = None,
        reference: OccupancyMap | None = None,
        on_mapped: Callable[[NDArray[np.float32]], None] | None = None,
    ) -> None:
        self.occupancy, self.reference = occupancy, reference
        self._max_range_m = max_range_m  # already applied; rounded to float32, points may be slightly farther away
        self._timer = timer or WallTimer()
        self._mapping, self._waiting = self._timer.measure(MAPPING), self._timer.measure(WAITING)
        self._thread = ThreadPoolExecutor(1, "map") if threads > 1 else None
        self._map_threads = max(1, threads - 1)  # one thread is needed for flying
        self._batch: list[Scan] = []
        self._batches_sent = self._batches_mapped = 0
        self._on_mapped = on_mapped if self._thread is not None else None
        self._in_flight: deque[Future[None]] = deque()

    def insert(self, points_world_m: NDArray[np.float32], origin_m: NDArray[np.float64]) -> None:
        """Insert a scan, either now or later with its batch."""
        self._batch.append((points_world_m, origin_m))
        if len(self._batch) < SCANS_PER_BATCH:
            return
        self._send_batch()
        while self._in_flight and self._in_flight[0].done():
            self._in_flight.popleft().result()
        if len(self._in_flight) > self._queue_limit():
            with self._waiting:
                self._in_flight.popleft().result()

    def when_mapped(self, job: Callable[[], None]) -> None:
        """Run a job when the map contains exactly the scans passed so far: now, or later on the map thread."""
        self._send_batch()
        self._run_in_order(job)

    def finish(self) -> None:
        """Wait until every scan is in the map."""
        self._send_batch()
        with self._waiting:
            while self._in_flight:
                self._in_flight.popleft().result()

    def _queue_limit(self) -> float:
        """Return the number of batches inserted in BACKLOG_S at the average rate so far."""
        batch_s = self._timer.wall_s[MAPPING] / max(1, self._batches_sent - len(self._in_flight))
        return min(max(BACKLOG_S / max(batch_s, 1e-9), BATCHES_MIN), BATCHES_MAX)

    def _run_in_order(self, job: Callable[[], None]) -> None:
        """Run a job after all earlier jobs: now, or later on the map thread."""
        if self._thread is None:
            job()
        else:
            self._in_flight.append(self._thread.submit(job))

    def _send_batch(self) -> None:
        batch, self._batch = self._batch, []
        if not batch:
            return
        self._batches_sent += 1
        self._run_in_order(lambda: self._insert_batch(batch))

    def _insert_batch(self, batch: list[Scan]) -> None:
        with self._mapping:
            points_world_m = np.concatenate([points for points, _ in batch])
            counts = np.array([len(points) for points, _ in batch])
            origins_m = np.array([origin_m for _, origin_m in batch])
            try:
                self.occupancy.insert_scans(points_world_m, counts, origins_m, self._max_range_m, self._map_threads)
            except ValueError:  # the map refused the whole batch, but the scans before the invalid one belong in it
                self._insert_one_by_one(self.occupancy, batch)
        self._batches_mapped += 1
        if self.reference is not None:
            with self._timer.measure(VERIFICATION):
                self._insert_one_by_one(self.reference, batch)
        if self._on_mapped is not None and self._batches_mapped == self._batches_sent:
            self._on_mapped(points_world_m)

    def _insert_one_by_one(self, occupancy: OccupancyMap, batch: list[Scan]) -> None:
        for points_m, origin_m in batch:
            occupancy.insert_scan(points_m, origin_m, self._max_range_m)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Insert all remaining scans, no matter how the flight ended.

        If inserting fails, the error is raised only if the flight itself raised none.
        """
        try:
            self.finish()
        except Exception:
            if error is None:
                raise
        finally:
            if self._thread is not None:
                self._thread.shutdown(wait=True)
