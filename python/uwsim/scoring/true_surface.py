"""The true surface as the voxels of a perfect map, each with sample points on the surface."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.base.polygon import inside
from uwsim.mapping.voxel_keys import voxel_keys

TERRAIN_LABEL = 1
MAX_VOXELS = 50_000_000
TILE_VOXELS = 256

Box = tuple[NDArray[np.float64], NDArray[np.float64]]
EVERYWHERE: Box = np.full(3, -np.inf), np.full(3, np.inf)


@dataclass(frozen=True, eq=False)
class SurfaceSamples:
    """Points on the true surface, sorted by voxel.

    points_world_m: (n, 3). voxel_of_sample: (n,), index into voxel_keys. voxel_keys: (v, 3) int64, sorted and unique.
    """

    points_world_m: NDArray[np.float64]
    voxel_of_sample: NDArray[np.int64]
    voxel_keys: NDArray[np.int64]


def surface_tiles(
    world: _core.World, resolution_m: float, area_world_m: NDArray[np.float64], within_m: Box = EVERYWHERE
) -> Iterator[SurfaceSamples]:
    """Yield the samples of each job in surface_tile_jobs, except empty ones."""
    tiles = (job() for job in surface_tile_jobs(world, resolution_m, area_world_m, within_m))
    yield from (tile for tile in tiles if len(tile.points_world_m))


def surface_tile_jobs(
    world: _core.World, resolution_m: float, area_world_m: NDArray[np.float64], within_m: Box = EVERYWHERE
) -> Iterator[Callable[[], SurfaceSamples]]:
    """Yield jobs that sample all triangles of terrain and solids inside the polygon, at most half a voxel apart.

    Each job samples one tile, and may run on any thread. A voxel counts as surface if it contains a sample, so a voxel
    that the surface merely clips (by less than about a third of its width) may not count. At most one sample is kept
    per octant of a voxel, since more would add no information. Parts of solids below the terrain (the lower half of a
    buried pipe) are not surface and are discarded.

    Tiles have at most TILE_VOXELS per side and share no voxel, so memory use does not depend on the size of the area or
    on triangles outside it. within_m: a box, corners (3,), outside which nothing is sampled. Raises ValueError, before
    the first tile, if the surface is estimated to have more than MAX_VOXELS voxels.
    """
    sampler = _core.SurfaceSampler(world, resolution_m, area_world_m, *within_m)
    if sampler.box_m is None:
        return
    _require_scorable(sampler.voxels_in_box, *sampler.box_m, area_world_m)
    lowest, highest = voxel_keys(np.stack(sampler.box_m), resolution_m).tolist()
    # one voxel more at either end, to allow for rounding
    axes = (range(low - 1, high + 2, TILE_VOXELS) for low, high in zip(lowest, highest, strict=True))
    for first in product(*axes):
        end = [min(low + TILE_VOXELS, high + 2) for low, high in zip(first, highest, strict=True)]
        yield partial(_sample_tile, sampler, first, end)


def _sample_tile(sampler: _core.SurfaceSampler, first: Sequence[int], end: Sequence[int]) -> SurfaceSamples:
    return SurfaceSamples(*sampler.sample(first, end))


def _require_scorable(
    box_voxels: float, low_m: NDArray[np.float64], high_m: NDArray[np.float64], area_world_m: NDArray[np.float64]
) -> None:
    x, y = (low + (high - low) * (np.arange(128) + 0.5) / 128 for low, high in zip(low_m[:2], high_m[:2], strict=True))
    grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    voxels = box_voxels * float(inside(grid, area_world_m).mean())
    if voxels > MAX_VOXELS:
        rule = f"must be at most {MAX_VOXELS / 1e6:g} million to be scored: choose larger voxels or a smaller area"
        raise ValueError(f"voxels of the true surface = about {voxels / 1e6:.0f} million: {rule}")


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
