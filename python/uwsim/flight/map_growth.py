"""Measures a flight's map as it grows: its size and its distance from the true surface, at increasing intervals."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from uwsim.mapping import OccupancyMap
from uwsim.simulator.simulator import Simulator

FIRST_S, FACTOR = 5.0, 1.25  # measured at FIRST_S x FACTOR^k, about 30 times in an hour
MOST_VOXELS = 20_000  # largest number of voxels whose distance is measured; if there are more, every n-th is taken


class GrowthRow(NamedTuple):
    """Measurements of the map at one time during the flight.

    area_m2: total area of the columns that contain an occupied voxel. distance_mean_m, distance_p95_m: mean and 95th
    percentile of the distances of occupied voxels from the true surface.
    """

    time_s: float
    voxels: int
    area_m2: float
    distance_mean_m: float
    distance_p95_m: float


def growth_row(occupancy: OccupancyMap, sim: Simulator, time_s: float) -> GrowthRow | None:
    """Measure a map; return None if it is empty."""
    voxels = occupancy.occupied_voxels()
    if not len(voxels):
        return None
    edge_m = occupancy.resolution_m
    east, north = np.floor(voxels[:, :2] / edge_m).astype(np.int64).T
    columns = len(np.unique((east << 32) + north))
    distances_m = sim.scene.distance_m(voxels[:: -(-len(voxels) // MOST_VOXELS)])
    p95_m = float(np.quantile(distances_m, 0.95))
    return GrowthRow(time_s, len(voxels), columns * edge_m**2, float(distances_m.mean()), p95_m)


class GrowthWatch:
    """Measures the map when due, as an Observer of the simulator's journal.

    when_mapped: runs a job as soon as the map contains all pings so far. begun_tick: tick at which the flight began.
    """

    def __init__(
        self,
        sim: Simulator,
        occupancy: OccupancyMap,
        when_mapped: Callable[[Callable[[], None]], None],
        *,
        begun_tick: int,
    ) -> None:
        self._sim, self._occupancy, self._when_mapped = sim, occupancy, when_mapped
        self._begun_tick, self._next_s = begun_tick, FIRST_S
        self.rows: list[GrowthRow] = []
        self.due_tick = self._tick_of_next()

    def observe(self) -> None:
        """Schedule a measurement to run once the map contains all pings so far."""
        time_s = (self._sim.tick - self._begun_tick) * self._sim.step_s
        self._go_on()
        self._when_mapped(lambda: self._measure(time_s))

    def _measure(self, time_s: float) -> None:
        row = growth_row(self._occupancy, self._sim, time_s)
        if row is not None:
            self.rows.append(row)

    def _go_on(self) -> None:
        self._next_s *= FACTOR
        self.due_tick = self._tick_of_next()

    def _tick_of_next(self) -> int:
        return self._begun_tick + round(self._next_s / self._sim.step_s)
