"""LiveMap: the OctoMap that a mission builds in flight from its own pings, with queries by water column."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uwsim.mapping import OccupancyMap
from uwsim.mapping.ranging import place_deviation_m
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.missions.planners.cells import Cell, Cells
from uwsim.navigation.control.protocols import PingLike
from uwsim.navigation.sensor_choice import height_above_bed_m

PING_PERIOD_S, LOOK_PERIOD_S = 0.5, 2.0
LONGEST_RAY_M = 30.0  # for echoes farther away, water is marked as free up to this distance


class LiveMap:
    """Builds a map from pings at the vehicle's estimated poses and from the bed directly below.

    cells: the columns used by `tops_m` and `certainty`. period_s: minimum time between inserted pings.
    """

    def __init__(self, vehicle: OwnVehicle, resolution_m: float, cells: Cells, period_s: float = PING_PERIOD_S) -> None:
        self.map = OccupancyMap(resolution_m=resolution_m)
        self._vehicle, self._cells, self._period_s = vehicle, cells, period_s
        self._next_s = self._next_look_s = -math.inf
        self._tops: dict[Cell, float] = {}

    def add(self, ping: PingLike, echoes_world_m: NDArray[np.float64]) -> None:
        """Insert a ping into the map, unless the previous one was inserted less than period_s ago.

        echoes_world_m: all of the ping's echoes (n, 3), of which those that the survey filters are left out.
        """
        now_s = self._vehicle.time_s
        if now_s < self._next_s:
            return
        self._next_s = now_s + self._period_s - 1e-6
        below_m = height_above_bed_m(self._vehicle)
        bed = np.asarray(self._vehicle.pose.position_world_m, np.float64) - (0.0, 0.0, below_m)
        met = np.isfinite(np.asarray(ping.points_sonar_m)[:, 0])
        kept = np.isfinite(self._kept_m(ping))[met]
        # as one scan, so that no ray of the ping marks the bed as free
        points = np.vstack([echoes_world_m[kept], bed]).astype(np.float32)
        self.map.insert_scan(points, ping.world_from_sonar[:3, 3], LONGEST_RAY_M)

    def _kept_m(self, ping: PingLike) -> NDArray[np.float32]:
        """Return a ping's ranges (beams,), with inf for echoes that the survey filters.

        A remote sonar has no chain: its server has filtered the ranges already.
        """
        chain = getattr(self._vehicle.sonar, "chain", None)
        return ping.ranges_m if chain is None else chain.kept_m(ping.ranges_m, place_deviation_m(ping))

    @property
    def tops_m(self) -> dict[Cell, float]:
        """Height of the highest occupied voxel in each column that has one, at most LOOK_PERIOD_S out of date."""
        if self._vehicle.time_s >= self._next_look_s:
            self._next_look_s = self._vehicle.time_s + LOOK_PERIOD_S
            self._tops = self._read_tops()
        return self._tops

    def certainty(self) -> dict[Cell, float]:
        """Return the highest occupancy probability in each column with occupied voxels."""
        voxels = self.map.occupied_voxels()
        probabilities = self.map.probability_at(voxels)
        order = np.argsort(probabilities, kind="stable")  # the most certain last: later entries replace earlier ones
        cells = self._cells.of(voxels[order])
        return {(i, j): p for (i, j), p in zip(cells.tolist(), probabilities[order].tolist(), strict=True)}

    def _read_tops(self) -> dict[Cell, float]:
        voxels = self.map.occupied_voxels()
        voxels = voxels[np.lexsort((voxels[:, 2],))]  # the highest last: later entries replace earlier ones
        cells = self._cells.of(voxels)
        return {(i, j): z for (i, j), z in zip(cells.tolist(), voxels[:, 2].tolist(), strict=True)}
