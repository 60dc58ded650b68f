"""The paper's chain from a ping to the map: string, decoded ranges, LaserScan, point cloud, world, OctoMap."""

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
from uwsim.survey.stages import VERIFICATION, WAITING, StageTimer

SCANS_A_BATCH = 16  # a map takes several together faster than one by one, and threads hand over less often
BACKLOG_S, BATCHES_MIN, BATCHES_MAX = 1.0, 4, 512
"""What may wait for the map's thread: so much of its work, within these. A save takes a second; Ctrl-C waits for it."""


Scan = tuple[NDArray[np.float32], NDArray[np.float64]]
"""Points in the world (n, 3) and where they were seen from (3,)."""


@dataclass(frozen=True, eq=False)
class SelfBox:
    """The vehicle's own hull as a box in the body frame, whose echoes are not the world's: corners (3,) [m]."""

    low_body_m: NDArray[np.float64]
    high_body_m: NDArray[np.float64]


class ScanChain:
    """Carries every ping through all the links into a map. A context manager: leaving it waits for the map.

    With more than one thread the map is filled beside the simulation, scans in their order, so that its bytes do not
    depend on the number of threads. tamper: stands for the channel; it gets the string and returns what arrives.
    reference: a map that gets every scan too, one by one, to be compared with.
    """

    def __init__(
        self,
        occupancy: OccupancyMap,
        model: int | _core.MultibeamModel,
        self_box: SelfBox,
        *,
        threads: int = 1,
        timer: StageTimer | None = None,
        tamper: Callable[[str], str] | None = None,
        reference: OccupancyMap | None = None,
    ) -> None:
        self.occupancy = occupancy
        self.reference = reference
        self.model = model if isinstance(model, _core.MultibeamModel) else ranging.MODELS[model]
        self.self_box = self_box
        self.timer = timer or StageTimer()
        self._tamper = tamper
        self._mapper = ThreadPoolExecutor(1, "map") if threads > 1 else None
        self._map_threads = max(1, threads - 1)  # one flies
        self._batch: list[Scan] = []
        self._batches_sent = 0
        self._in_flight: deque[Future[None]] = deque()

    def insert(
        self,
        ranges_m: NDArray[np.float32],
        world_from_body: NDArray[np.float64],
        world_from_sonar: NDArray[np.float64],
        stamp_s: float,
    ) -> NDArray[np.float32]:
        """One ping (beams,) taken at these poses (4, 4); returns its echoes in the world, (n, 3)."""
        with self.timer.measure("codec"):
            text = ranging.encode_depth_string(ranges_m, self.model)
            if self._tamper is not None:
                text = self._tamper(text)
            decoded = ranging.decode_depth_string(text, self.model)
        with self.timer.measure("conversion"):
            scan = ranging.to_laser_scan(decoded, self.model, stamp_s)
            points_sonar = ranging.filter_range(ranging.to_point_cloud(scan), scan.range_min, scan.range_max)
            body_from_sonar = np.linalg.inv(world_from_body) @ world_from_sonar
            points_body = ranging.transform_points(points_sonar, body_from_sonar)
            others = ranging.remove_box(points_body, self.self_box.low_body_m, self.self_box.high_body_m)
            points_world = ranging.transform_points(others, world_from_body)
        self._to_map(points_world, world_from_sonar[:3, 3].copy())
        return points_world

    def when_mapped(self, job: Callable[[], None]) -> None:
        """Do this when the map holds every scan so far and none after: at once, or beside the flight."""
        self._send_batch()
        self._in_turn(job)

    def finish(self) -> None:
        """Wait until every scan is in the map."""
        self._send_batch()
        with self.timer.measure(WAITING):
            while self._in_flight:
                self._in_flight.popleft().result()

    def _to_map(self, points_world_m: NDArray[np.float32], origin_m: NDArray[np.float64]) -> None:
        self._batch.append((points_world_m, origin_m))
        if len(self._batch) < SCANS_A_BATCH:
            return
        self._send_batch()
        while self._in_flight and self._in_flight[0].done():
            self._in_flight.popleft().result()
        if len(self._in_flight) > self._most_in_flight():
            with self.timer.measure(WAITING):
                self._in_flight.popleft().result()

    def _most_in_flight(self) -> float:
        """As many batches as the map is seen to take in BACKLOG_S."""
        batch_s = self.timer.wall_s["map"] / max(1, self._batches_sent - len(self._in_flight))
        return min(max(BACKLOG_S / max(batch_s, 1e-9), BATCHES_MIN), BATCHES_MAX)

    def _in_turn(self, job: Callable[[], None]) -> None:
        """Where the map is filled, after what was sent before."""
        if self._mapper is None:
            job()
        else:
            self._in_flight.append(self._mapper.submit(job))

    def _send_batch(self) -> None:
        batch, self._batch = self._batch, []
        if not batch:
            return
        self._batches_sent += 1
        self._in_turn(lambda: self._insert(batch))

    def _insert(self, batch: list[Scan]) -> None:
        # The scan's own range_max has done its work; float32 points may come out a hair longer.
        max_range_m = self.model.range_max_m
        with self.timer.measure("map"):
            points_world_m = np.concatenate([points for points, _ in batch])
            counts = np.array([len(points) for points, _ in batch])
            origins_m = np.array([origin_m for _, origin_m in batch])
            try:
                self.occupancy.insert_scans(points_world_m, counts, origins_m, max_range_m, self._map_threads)
            except ValueError:  # took none of them: the scans before the one that is refused were seen
                for points_m, origin_m in batch:
                    self.occupancy.insert_scan(points_m, origin_m, max_range_m)
        if self.reference is None:
            return
        with self.timer.measure(VERIFICATION):
            for points_m, origin_m in batch:
                self.reference.insert_scan(points_m, origin_m, max_range_m)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Whatever ends the flight, what was seen gets into the map; the first error is the one to tell."""
        try:
            self.finish()
        except Exception:
            if error is None:
                raise
        finally:
            if self._mapper is not None:
                self._mapper.shutdown(wait=True)
