"""The true surface, sampled on a thread while the survey that it judges is still in flight."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.scoring.true_surface import SurfaceSamples, TooManyVoxelsError, surface_tile_jobs

MAX_KEPT_VOXELS = 1_000_000  # some 250 bytes each are kept; a larger surface is sampled tile by tile when it is scored


class SurfaceAhead:
    """Samples a world's surface in a polygon (k, 2) on a thread of its own. A context manager: leaving it ends that.

    Native code and NumPy's large operations do not hold Python's lock, so that the flight goes on beside it.
    """

    def __init__(self, world: _core.World, resolution_m: float, area_world_m: NDArray[np.float64]) -> None:
        self._cancelled = threading.Event()
        self._pool = ThreadPoolExecutor(1, "surface")
        self._tiles = self._pool.submit(self._sample, partial(surface_tile_jobs, world, resolution_m, area_world_m))

    def tile_jobs(self) -> list[Callable[[], SurfaceSamples]] | None:
        """Wait for the tiles and return them as surface_tile_jobs does; None if the surface is too large to be kept."""
        tiles = self._tiles.result()
        return None if tiles is None else [partial(_given, tile) for tile in tiles]

    def _sample(self, jobs: Callable[..., Iterable[Callable[[], SurfaceSamples]]]) -> list[SurfaceSamples] | None:
        tiles = []
        try:
            for job in jobs(max_voxels=MAX_KEPT_VOXELS):
                if self._cancelled.is_set():
                    return None
                tiles.append(job())
        except TooManyVoxelsError:
            return None
        return tiles

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._cancelled.set()
        self._pool.shutdown()


def _given(tile: SurfaceSamples) -> SurfaceSamples:
    return tile
