"""DistanceField, the distance to the nearest obstacle of a map: the Python interface of `_core.DistanceField`."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwsim import _core
from uwsim.base.sealed import Sealed
from uwsim.mapping.occupancy_map import OccupancyMap


class DistanceField(Sealed):
    """The Euclidean distance to the nearest occupied voxel, in a box of a map, for planners.

    Computed by dynamicEDT3D (B. Lau, C. Sprunk, W. Burgard, Robotics and Autonomous Systems 61(10), 2013), which ships
    with OctoMap. Distances are between the centres of voxels, and truncated at max_distance_m. A voxel's distance may
    exceed the exact one by a fraction of a voxel (docs/guides/maps.md).

    low_world_m, high_world_m: (3,), corners of the box; the field covers the voxels whose centres lie in it. There may
    be up to 32 million voxels, of 32 bytes each. max_distance_m: from one to 1,000 voxels. unknown_is_occupied: whether
    unknown voxels are obstacles, too. Raises ValueError. Calls release the GIL.
    """

    max_distance_m: float
    _fixed_when = "the field is made"

    def __init__(
        self,
        occupancy_map: OccupancyMap,
        low_world_m: ArrayLike,
        high_world_m: ArrayLike,
        *,
        max_distance_m: float = 5.0,
        unknown_is_occupied: bool = False,
    ) -> None:
        if not isinstance(occupancy_map, OccupancyMap):
            raise TypeError(f"occupancy_map = {occupancy_map!r}: must be an OccupancyMap")
        self._map = occupancy_map
        self.max_distance_m = max_distance_m
        self._field = _core.DistanceField(
            occupancy_map._map,
            low_world_m,
            high_world_m,
            max_distance_m=max_distance_m,
            unknown_is_occupied=unknown_is_occupied,
        )

    def update(self) -> int:
        """Bring the distances up to date with the map; return how many voxels became or stopped being obstacles.

        Only voxels whose nearest obstacle may have changed are visited.
        """
        return self._field.update(self._map._map)

    def distance_m(self, points_world_m: ArrayLike) -> NDArray[np.float32]:
        """Return the distances (n,) float32 at points_world_m (n, 3), interpolated trilinearly; NaN outside."""
        return self._field.distance_m(points_world_m)

    def gradient(self, points_world_m: ArrayLike) -> NDArray[np.float64]:
        """Return the gradients (n, 3) of `distance_m`, which point away from obstacles; NaN outside."""
        return self._field.gradient(points_world_m)

    def grid(self) -> NDArray[np.float32]:
        """Return the distances of all voxels, `shape` float32 [m]."""
        return self._field.grid()

    @property
    def shape(self) -> tuple[int, int, int]:
        """Numbers of voxels along x, y and z."""
        nx, ny, nz = self._field.shape
        return nx, ny, nz

    @property
    def low_centre_world_m(self) -> NDArray[np.float64]:
        """The centre of the voxel with the lowest indices, (3,)."""
        return self._field.low_centre_world_m

    def __repr__(self) -> str:
        corner = ", ".join(f"{x:g}" for x in self.low_centre_world_m)
        return (
            f"DistanceField(shape={self.shape}, low_centre_world_m=({corner}), max_distance_m={self.max_distance_m:g})"
        )
