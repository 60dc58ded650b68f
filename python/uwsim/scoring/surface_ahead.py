"""Samples the true surface during a survey, while the map thread is idle."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.scoring.true_surface import SurfaceSamples, surface_tile_jobs


class SurfaceAhead:
    """Samples a world's surface in an area, and measures its distance from the voxels that contain echoes.

    A score that receives this object computes only the remaining part, with the same result. Not thread-safe.
    voxels: the map's voxels, resolution_m wide. area_world_m: (k, 2), the polygon to be scored.
    """

    def __init__(
        self, world: _core.World, rays: _core.RayScene, resolution_m: float, area_world_m: NDArray[np.float64]
    ) -> None:
        self.voxels = _core.SurfaceVoxels(rays, resolution_m)
        self._begin = partial(surface_tile_jobs, world, resolution_m, area_world_m)
        self._left: deque[Callable[[], SurfaceSamples]] | None = None
        self._sampled: list[SurfaceSamples] = []

    def look_at(self, points_world_m: NDArray[np.float32]) -> None:
        """Measure the voxels that contain points (n, 3), and sample one more tile of the surface."""
        self.voxels.look_at(points_world_m)
        if self._left is None:
            self._left = self._all_tiles()
        if self._left:
            self._sampled.append(self._left.popleft()())

    def tiles(self) -> Iterator[Callable[[], SurfaceSamples]]:
        """Yield the jobs from surface_tile_jobs, some of them already done. Raises the same errors."""
        left = self._begin() if not self._sampled else self._left or ()
        yield from (partial(_itself, tile) for tile in self._sampled)
        yield from left

    def _all_tiles(self) -> deque[Callable[[], SurfaceSamples]]:
        try:
            return deque(self._begin())
        except ValueError:  # too large to be scored; the score itself raises this error later
            return deque()


def _itself(tile: SurfaceSamples) -> SurfaceSamples:
    return tile
