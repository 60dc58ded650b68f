"""The ground of a basin, such as a pool: an obstacle whose rim stands out of the water all around, for the chart."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim import _core

CELLS, RIM_CELLS = 200, 64
"""Heights along the longer edge of a basin, and places along each edge of its rim."""
INSET = 0.01  # of the rim from the edge, as a share of the basin's size
HIGH_M, DEEP_M = 100.0, 1000.0
BROAD = 0.25
"""The share of a basin's area from which on another obstacle in it, such as its fittings, is ground as well."""

Mesh = tuple[NDArray[np.float64], NDArray[np.integer[Any]]]


class Basin(NamedTuple):
    """heights_m: (rows, columns), from the south-west corner. names: of the obstacles that are its ground."""

    heights_m: NDArray[np.float64]
    corner_m: NDArray[np.float64]
    spacing_m: float
    names: tuple[str, ...]


def basin_among(meshes: Mapping[str, Mesh]) -> Basin | None:
    """Return the ground of the first basin among meshes in the world, by name; None without one."""
    for name, mesh in meshes.items():
        low, high = (np.asarray(end(mesh[0], axis=0))[:2] for end in (np.min, np.max))
        if not _is_basin(_rays({name: mesh}), low, high):
            continue
        area_m2 = np.prod(high - low)
        broad = {each: found for each, found in meshes.items() if each == name or _area_m2(found) > BROAD * area_m2}
        spacing_m = float((high - low).max() / CELLS)
        columns, rows = np.maximum(np.ceil((high - low) / spacing_m).astype(int), 1)
        east, north = np.meshgrid(low[0] + spacing_m * np.arange(columns + 1), low[1] + spacing_m * np.arange(rows + 1))
        heights_m = _heights_m(_rays(broad), np.column_stack([east.ravel(), north.ravel()]))
        return Basin(heights_m.reshape(east.shape), low, spacing_m, tuple(broad))
    return None


def _is_basin(rays: _core.RayScene, low: NDArray[np.float64], high: NDArray[np.float64]) -> bool:
    """Return whether a solid's rim is above the water everywhere, and its middle below."""
    inset = INSET * (high - low)
    share = np.linspace(0.0, 1.0, RIM_CELLS)
    edges = [np.column_stack([share, np.full_like(share, end)]) for end in (0.0, 1.0)]
    rim = np.concatenate([*edges, *(edge[:, ::-1] for edge in edges)])
    rim_m = _heights_m(rays, low + inset + rim * (high - low - 2.0 * inset))
    return bool((rim_m > 0.0).all() and _heights_m(rays, 0.5 * (low + high)[None])[0] < 0.0)


def _area_m2(mesh: Mesh) -> float:
    return float(np.prod(np.ptp(mesh[0][:, :2], axis=0)))


def _rays(meshes: Mapping[str, Mesh]) -> _core.RayScene:
    world = _core.World()
    for name, (vertices, triangles) in meshes.items():
        world.add_solid(name, np.asarray(vertices, np.float64), np.asarray(triangles, np.uint32))
    return _core.RayScene(world)


def _heights_m(rays: _core.RayScene, places_m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the heights of the highest surface at places (n, 2); nan where there is none."""
    above = np.column_stack([places_m, np.full(len(places_m), HIGH_M)])
    hits = rays.cast(above, np.tile([0.0, 0.0, -1.0], (len(above), 1)), DEEP_M)
    return np.where(np.isfinite(hits.ranges_m), HIGH_M - hits.ranges_m, np.nan)
