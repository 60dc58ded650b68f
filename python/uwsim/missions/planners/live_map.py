"""LiveMap: the OctoMap that a mission builds from its own pings in flight, and its content in each column of water."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uwsim.mapping import OccupancyMap
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.missions.planners.cells import Cell, Cells
from uwsim.navigation.control.protocols import PingLike

PING_PERIOD_S, LOOK_PERIOD_S = 0.5, 2.0
LONGEST_RAY_M = 30.0  # longer echoes free water up to this distance


class LiveMap:
    """Builds a map of the pings added to it, at the vehicle's estimated poses, and of the bed straight below.

    cells: the columns of `tops_m` and `certainty`. period_s: between the pings that are inserted.
    """

    def __init__(self, vehicle: OwnVehicle, resolution_m: float, cells: Cells, period_s: float = PING_PERIOD_S) -> None:
        self.map = OccupancyMap(resolution_m=resolution_m)
        self._vehicle, self._cells, self._period_s = vehicle, cells, period_s
        self._next_s = self._next_look_s = -math.inf
        self._tops: dict[Cell, float] = {}

    def add(self, ping: PingLike, echoes_world_m: NDArray[np.float64]) -> None:
        """Insert a ping into the map, if the last one is old enough."""
        now_s = self._vehicle.time_s
        if now_s < self._next_s:
            return
        self._next_s = now_s + self._period_s - 1e-6
        below_m = float(self._vehicle.sensors["altitude"].read())
        bed = np.asarray(self._vehicle.pose.position_world_m, np.float64) - (0.0, 0.0, below_m)
        # as one scan, so that none of its rays frees the bed
        points = np.vstack([echoes_world_m, bed]).astype(np.float32)
        self.map.insert_scan(points, ping.world_from_sonar[:3, 3], LONGEST_RAY_M)

    @property
    def tops_m(self) -> dict[Cell, float]:
        """Return the height of the highest occupied voxel by column, if there is one; at most LOOK_PERIOD_S old."""
        if self._vehicle.time_s >= self._next_look_s:
            self._next_look_s = self._vehicle.time_s + LOOK_PERIOD_S
            self._tops = self._read_tops()
        return self._tops

    def certainty(self) -> dict[Cell, float]:
        """Return the largest probability of an occupied voxel by column, if there is one."""
        voxels = self.map.occupied_voxels()
        probabilities = self.map.probability_at(voxels)
        order = np.argsort(probabilities, kind="stable")  # the most certain last, so that it is kept
        cells = self._cells.of(voxels[order])
        return {(i, j): p for (i, j), p in zip(cells.tolist(), probabilities[order].tolist(), strict=True)}

    def _read_tops(self) -> dict[Cell, float]:
        voxels = self.map.occupied_voxels()
        voxels = voxels[np.lexsort((voxels[:, 2],))]  # the highest last, so that it is kept
        cells = self._cells.of(voxels)
        return {(i, j): z for (i, j), z in zip(cells.tolist(), voxels[:, 2].tolist(), strict=True)}
