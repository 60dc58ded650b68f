"""The paper's chain from a ping to the map: depth string, decoded ranges, LaserScan, point cloud, world, OctoMap."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from uwsim import _core, ranging
from uwsim.mapping import OccupancyMap
from uwsim.sealed import Sealed
from uwsim.survey.wall_time import VERIFICATION, WAITING, WallTimer

SCANS_PER_BATCH = 16  # a map inserts several scans faster than one by one, and threads synchronise less often
BACKLOG_S, BATCHES_MIN, BATCHES_MAX = 1.0, 4, 512
"""Limit of the map thread's queue: BACKLOG_S of its work, within these numbers of batches.

A save takes about a second, during which the queue fills; Ctrl-C waits until it is empty.
"""


Scan = tuple[NDArray[np.float32], NDArray[np.float64]]
"""Points in the world (n, 3), and the sonar's position (3,)."""


@dataclass(frozen=True, eq=False)
class HullBox:
    """A box about the vehicle's own hull, body frame, corners (3,) [m]. Echoes from inside it are discarded."""

    low_body_m: NDArray[np.float64]
    high_body_m: NDArray[np.float64]


class PingToMap(Sealed):
    """Passes every ping through the chain into a map. A context manager: leaving it waits until the map is filled.

    With more than one thread the map is filled in parallel to the simulation. Scans are inserted in order, so the
    map's bytes do not depend on the number of threads. transmit: simulates the channel; receives each depth string and
    returns the string that arrives. reference: a second map, which gets every scan one by one, for comparison.
    outlier_filter: whether ranging.reject_outliers is a link of the chain. max_uncertainty_m: the limit of
    ranging.reject_uncertain; None if that is no link. on_mapped: called on the map's thread with points (n, 3) that
    were inserted, when no other scans wait; with one thread never.
    """

    occupancy: OccupancyMap
    reference: OccupancyMap | None
    model: _core.MultibeamModel
    hull_box: HullBox
    timer: WallTimer
    _fixed_when = "the chain is made"

    def __init__(
        self,
        occupancy: OccupancyMap,
        model: int | _core.MultibeamModel,
        hull_box: HullBox,
        *,
        threads: int = 1,
        timer: WallTimer | None = None,
        transmit: Callable[[str], str] | None = None,
        reference: OccupancyMap | None = None,
        outlier_filter: bool = False,
        max_uncertainty_m: float | None = None,
        on_mapped: Callable[[NDArray[np.float32]], None] | None = None,
    ) -> None:
        self.occupancy = occupancy
        self.reference = reference
        self.model = model if isinstance(model, _core.MultibeamModel) else ranging.MODELS[model]
        self.hull_box = hull_box
        self.timer = timer or WallTimer()
        self._codec, self._conversion = self.timer.measure("codec"), self.timer.measure("conversion")
        self._transmit = transmit
        self._outlier_filter = outlier_filter
        self._max_uncertainty_m = max_uncertainty_m
        self._mapper = ThreadPoolExecutor(1, "map") if threads > 1 else None
        self._map_threads = max(1, threads - 1)  # one thread flies
        self._batch: list[Scan] = []
        self._batches_sent = self._batches_mapped = 0
        self._on_mapped = on_mapped if self._mapper is not None else None
        self._in_flight: deque[Future[None]] = deque()

    def insert(
        self,
        ranges_m: NDArray[np.float32],
        world_from_body: NDArray[np.float64],
        world_from_sonar: NDArray[np.float64],
        stamp_s: float,
        deviation_m: NDArray[np.float32] | None = None,
    ) -> NDArray[np.float32]:
        """Pass on one ping, ranges (beams,), taken at these poses (4, 4); returns its echoes in the world, (n, 3).

        deviation_m: (beams,), of the echoes' places, where they are known: in physics mode.
        """
        with self._codec:
            if deviation_m is not None and self._max_uncertainty_m is not None:
                ranges_m = ranging.reject_uncertain(ranges_m, deviation_m, self._max_uncertainty_m)
            text = ranging.encode_depth_string(ranges_m, self.model)
            if self._transmit is not None:
                text = self._transmit(text)
            decoded = ranging.decode_depth_string(text, self.model)
        with self._conversion:
            scan = ranging.to_laser_scan(decoded, self.model, stamp_s)
            if self._outlier_filter:
                scan = ranging.reject_outliers(scan)
            points_sonar = ranging.filter_range(ranging.to_point_cloud(scan), scan.range_min, scan.range_max)
            body_from_sonar = ranging.relative_transform(world_from_body, world_from_sonar)
            points_body = ranging.transform_points(points_sonar, body_from_sonar)
            others = ranging.remove_box(points_body, self.hull_box.low_body_m, self.hull_box.high_body_m)
            points_world = ranging.transform_points(others, world_from_body)
        self._queue_scan(points_world, world_from_sonar[:3, 3].copy())
        return points_world

    def when_mapped(self, job: Callable[[], None]) -> None:
        """Run a job when the map holds every scan inserted so far and none later: now, or on the map's thread."""
        self._send_batch()
        self._run_in_order(job)

    def finish(self) -> None:
        """Wait until every scan is in the map."""
        self._send_batch()
        with self.timer.measure(WAITING):
            while self._in_flight:
                self._in_flight.popleft().result()

    def _queue_scan(self, points_world_m: NDArray[np.float32], origin_m: NDArray[np.float64]) -> None:
        self._batch.append((points_world_m, origin_m))
        if len(self._batch) < SCANS_PER_BATCH:
            return
        self._send_batch()
        while self._in_flight and self._in_flight[0].done():
            self._in_flight.popleft().result()
        if len(self._in_flight) > self._queue_limit():
            with self.timer.measure(WAITING):
                self._in_flight.popleft().result()

    def _queue_limit(self) -> float:
        """Return the number of batches that the map inserts in BACKLOG_S, by its average so far."""
        batch_s = self.timer.wall_s["map"] / max(1, self._batches_sent - len(self._in_flight))
        return min(max(BACKLOG_S / max(batch_s, 1e-9), BATCHES_MIN), BATCHES_MAX)

    def _run_in_order(self, job: Callable[[], None]) -> None:
        """Run a job after all jobs before it: now, or on the map's thread."""
        if self._mapper is None:
            job()
        else:
            self._in_flight.append(self._mapper.submit(job))

    def _send_batch(self) -> None:
        batch, self._batch = self._batch, []
        if not batch:
            return
        self._batches_sent += 1
        self._run_in_order(lambda: self._insert_batch(batch))

    def _insert_batch(self, batch: list[Scan]) -> None:
        # The scan's own range_max has already been applied; float32 points may come out slightly longer.
        max_range_m = self.model.range_max_m
        with self.timer.measure("map"):
            points_world_m = np.concatenate([points for points, _ in batch])
            counts = np.array([len(points) for points, _ in batch])
            origins_m = np.array([origin_m for _, origin_m in batch])
            try:
                self.occupancy.insert_scans(points_world_m, counts, origins_m, max_range_m, self._map_threads)
            except ValueError:  # refuses the whole batch; the scans before the invalid one belong in the map
                for points_m, origin_m in batch:
                    self.occupancy.insert_scan(points_m, origin_m, max_range_m)
        self._batches_mapped += 1
        if self.reference is not None:
            with self.timer.measure(VERIFICATION):
                for points_m, origin_m in batch:
                    self.reference.insert_scan(points_m, origin_m, max_range_m)
        if self._on_mapped is not None and self._batches_mapped == self._batches_sent:
            self._on_mapped(points_world_m)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Insert all scans, however the flight ended; an error in doing so is raised only if the flight raised none."""
        try:
            self.finish()
        except Exception:
            if error is None:
                raise
        finally:
            if self._mapper is not None:
                self._mapper.shutdown(wait=True)
