"""A sonar survey over a measured sea floor, scored against the uncertainty of the measurement and against S-44.

The sea floor is a Bathymetric Attributed Grid of NOAA survey F00788: depths and their uncertainties at nodes 8 m apart.
A multibeam sonar at known positions surveys it in lines, and the depth at a node is the mean of the soundings in its
cell. The measured depths are the simulator's own terrain: the check shows that a survey returns them, and predicts
nothing. Positions and attitudes have no error, so the differences are due to the sonar, the speckle and the relief
within a cell.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from rasterio import open as open_raster
from rasterio.windows import Window
from rasterio.windows import bounds as window_bounds

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.evidence.validate.check import Check, Curve, at_most
from uwsim.evidence.validate.reality.kinds import AS_MEASURED
from uwsim.evidence.validate.sonars.table import WATERS, Cell, acoustics
from uwsim.instruments.sonars.soundings import sound_points, sound_speed_profile
from uwsim.scenario.terrains.elevations import raster_heights
from uwsim.scenario.terrains.raster import RasterTerrain

FILE = "bathymetry/F00788_SR_8m.bag"
GROUP = f"{AS_MEASURED}: NOAA F00788"
WINDOW = Window(15, 120, 50, 50)
"""The largest square of the grid without a gap."""
NODE_M, SPACING_M, EDGE = 8.0, 4.0, 3
LINE_M, PING_M = 60.0, 4.0
CELL = Cell("em2040-04", 300, "ocean")
DOWN_ACROSS_Y_XYZW = (0.0, math.sqrt(0.5), 0.0, math.sqrt(0.5))


@dataclass(frozen=True)
class Floor:
    """Depths and stated uncertainties [m] at nodes (n, n), from south to north; centre, in the file's coordinates."""

    depth_m: Floats
    uncertainty_m: Floats
    centre: tuple[float, float]

    @property
    def half_m(self) -> float:
        """Half of the distance between the outermost nodes."""
        return NODE_M * (len(self.depth_m) - 1) / 2


def read_floor(path: Path) -> Floor:
    """Read the square of the grid."""
    with open_raster(path) as grid:
        elevation_m, uncertainty_m = (grid.read(band, window=WINDOW)[::-1].astype(np.float64) for band in (1, 2))
        west, south, east, north = window_bounds(WINDOW, grid.transform)
    return Floor(-elevation_m, uncertainty_m, ((west + east) / 2, (south + north) / 2))


def soundings(path: Path, floor: Floor) -> Floats:
    """Return the soundings (n, 3) of a survey of the square in lines from west to east."""
    half_m = floor.half_m
    spec = RasterTerrain(
        source="raster", file=path, band=1, water_level_m=0.0, centre=floor.centre,
        size_m=(2 * half_m, 2 * half_m), spacing_m=SPACING_M, interpolation="linear", fill_nodata=True,
    )  # fmt: skip
    world = _core.World()
    world.set_terrain(raster_heights(spec).astype(np.float32), SPACING_M, (-half_m, -half_m))
    scene, water = _core.RayScene(world), WATERS[CELL.water].core_water()
    sonar = _core.AcousticMultibeam(CELL.fan, acoustics(CELL.array, CELL.frequency_khz), water)
    profile = sound_speed_profile(water)
    lines = np.arange(-half_m + LINE_M / 2, half_m, LINE_M)
    places = [(x, y) for y in lines for x in np.arange(-half_m, half_m, PING_M)]
    points = [
        sound_points(sonar.ping(scene, (x, y, -2.0), DOWN_ACROSS_Y_XYZW, tick=tick), profile)
        for tick, (x, y) in enumerate(places)
    ]
    found = np.concatenate(points)
    return found[np.isfinite(found).all(axis=1)]


def gridded_m(points: Floats, floor: Floor) -> Floats:
    """Return the mean depth of the soundings in each node's cell (n, n); NaN without a sounding."""
    nodes = len(floor.depth_m)
    row, column = (np.rint((points[:, axis] + floor.half_m) / NODE_M).astype(int) for axis in (1, 0))
    inside = (row >= 0) & (row < nodes) & (column >= 0) & (column < nodes)
    cell = (row * nodes + column)[inside]
    counts = np.bincount(cell, minlength=nodes**2)
    sums = np.bincount(cell, weights=-points[inside, 2], minlength=nodes**2)
    return np.where(counts > 0, sums / np.maximum(counts, 1), np.nan).reshape(nodes, nodes)


def checks(data: Path) -> list[Check]:
    """Return the checks, with the depths along the middle line.

    Nodes near the edge, where footprints reach beyond the terrain, are not scored.
    """
    floor = read_floor(data / FILE)
    found_m = gridded_m(soundings(data / FILE, floor), floor)
    error_m = found_m - floor.depth_m
    inner = (slice(EDGE, -EDGE), slice(EDGE, -EDGE))
    depth_m, stated_m = floor.depth_m[inner], floor.uncertainty_m[inner]
    middle = len(found_m) // 2
    lines = {"measured": floor.depth_m[middle], "surveyed": found_m[middle]}
    line = Curve(NODE_M * np.arange(len(found_m)) - floor.half_m, lines, "east [m]", "m", "depth along the middle line")

    def beyond(limit_m: Floats) -> float:
        return float(np.mean(~(np.abs(error_m[inner]) <= limit_m)))

    return [
        replace(at_most(GROUP, "share of nodes beyond their stated uncertainty", 0.05, beyond(stated_m)), curve=line),
        at_most(GROUP, "share beyond S-44 Special Order", 0.05, beyond(np.hypot(0.25, 0.0075 * depth_m))),
        at_most(GROUP, "share beyond S-44 Exclusive Order", 0.05, beyond(np.hypot(0.15, 0.0075 * depth_m))),
        at_most(GROUP, "median error, absolute value", 0.02, float(abs(np.median(error_m[inner]))), "m"),
    ]
