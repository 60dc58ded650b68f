"""AreaChart: the parts of an area that a vehicle may enter, as far as its sonar has shown, and the paths to them.

The chart is a raster of the area's bounding box. A cell is open if it lies in the area and is at least KEEP_M from
everything too high to pass over; unknown water is open. Paths are found with Dijkstra's algorithm over open cells, and
straightened wherever a straight line stays in them, so that no path leaves the area, concave or not.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arrays import Floats
from uwsim.mapping import OccupancyMap
from uwsim.missions.grid_ways import Grid, GridWays, straightened

BEYOND_M = 2.0  # how far outside the area paths may lead
KEEP_M = 3.5  # distance from anything that cannot be passed over
FINEST_M, MOST_CELLS = 1.0, 300  # minimum edge length of a cell, and maximum number of cells along a side
PATCH_M = 3.0
ECHOES_IN_A_CELL = 3  # fewer echoes in a ping may be false detections


class AreaChart:
    """The chart of a polygon (k, 2). Nothing higher than top_z_m can be passed over.

    start_m: the vehicle's position, (2,). If it is outside the area, the vehicle may approach through the convex hull
    of the area and start_m until it reaches the area.
    """

    def __init__(self, area_m: Sequence[Sequence[float]] | Floats, top_z_m: float, start_m: Floats) -> None:
        import shapely  # imported here, since it takes 0.2 s

        polygon = shapely.Polygon(area_m)
        area = polygon.buffer(BEYOND_M)
        whole = shapely.union(polygon, shapely.Point(start_m)).convex_hull.buffer(BEYOND_M)
        low_x, low_y, high_x, high_y = whole.bounds
        edge_m = max(FINEST_M, max(high_x - low_x, high_y - low_y) / MOST_CELLS)
        low = np.array([low_x, low_y]) - edge_m
        shape = tuple((np.ceil((np.array([high_x, high_y]) - low) / edge_m).astype(int) + 1).tolist())
        self.grid = Grid(low, edge_m, shape)
        self._top_z_m = top_z_m
        places = self.grid.all_centres()
        self._area = np.asarray(shapely.contains_xy(area, places).reshape(shape))
        self._inner = np.asarray(shapely.contains_xy(polygon, places).reshape(shape))
        self._allowed = np.asarray(shapely.contains_xy(whole, places).reshape(shape))
        self._shoal, self._near, self._seen, self._been = (np.zeros(shape, bool) for _ in range(4))
        reach = math.ceil(KEEP_M / edge_m)
        disc = np.mgrid[-reach : reach + 1, -reach : reach + 1].reshape(2, -1).T
        self._disc = disc[np.linalg.norm(disc, axis=1) * edge_m <= KEEP_M]
        self.visit(start_m)

    def visit(self, point_m: Floats) -> None:
        """Record the vehicle's position, (2,); once the vehicle has been in the area, paths no longer leave it."""
        (cell,), (held,) = self.cells_of(point_m[None])
        if held:
            self._been[tuple(cell)] = True
            if self._area[tuple(cell)]:
                self._allowed = self._area

    def add(self, echoes_world_m: Floats) -> None:
        """Chart the echoes of a ping, (n, 3)."""
        cells, held = self.cells_of(echoes_world_m[:, :2])
        self._seen[tuple(cells[held].T)] = True
        high = cells[held & (echoes_world_m[:, 2] > self._top_z_m)]
        if len(high) >= ECHOES_IN_A_CELL:
            found, counts = np.unique(high, axis=0, return_counts=True)
            self._close(found[counts >= ECHOES_IN_A_CELL])

    def add_map(self, occupancy: OccupancyMap) -> None:
        """Chart everything in a map that is too high, by casting rays down from the surface, one voxel apart."""
        step_m = min(occupancy.resolution_m, self.grid.edge_m)
        counts = np.ceil(np.array(self._shoal.shape) * self.grid.edge_m / step_m).astype(int)
        places = Grid(self.grid.low_m, step_m, tuple(counts.tolist())).all_centres()
        origins = np.column_stack([places, np.full(len(places), -0.5 * occupancy.resolution_m)])
        casts = occupancy.cast_rays(origins, np.tile([0.0, 0.0, -1.0], (len(places), 1)), -self._top_z_m, True)
        cells, held = self.cells_of(places[casts.states == 1])
        self._close(np.unique(cells[held], axis=0))

    def close(self, point_m: Sequence[float] | Floats) -> None:
        """Mark the water around a point (2,) as closed for a reason other than height."""
        cells, held = self.cells_of(np.atleast_2d(np.asarray(point_m, np.float64)))
        self._close(cells[held])

    def open_at(self, points_m: Floats) -> NDArray[np.bool_]:
        """Return a mask (n,) of the points (n, 2) where a vehicle may be, as far as is known."""
        return self._at(self._allowed & ~self._near, points_m)

    def seen_at(self, points_m: Floats) -> NDArray[np.bool_]:
        """Return a mask (n,) of the points (n, 2) in cells from which the sonar has received an echo."""
        return self._at(self._seen, points_m)

    def open_places(self) -> Floats:
        """Return the centres (n, 2) of the open cells."""
        return self.grid.centres(np.argwhere(self._allowed & ~self._near))

    def unseen_patches(self) -> Floats:
        """Return the centres (n, 2) of the PATCH_M squares in the area whose open cells are at least half unseen."""
        wanted = self._inner & ~self._near
        size = max(1, round(PATCH_M / self.grid.edge_m))
        cells = np.argwhere(wanted)
        across = wanted.shape[1] // size + 1
        number = cells // size @ (across, 1)
        unseen, all_of_it = np.bincount(number, ~self._seen[tuple(cells.T)]), np.bincount(number)
        squares = np.flatnonzero((unseen >= 0.5 * all_of_it) & (unseen >= 0.25 * size**2))
        middles = np.column_stack(np.divmod(squares, across)) * size + size // 2
        middles = np.minimum(middles, np.array(wanted.shape) - 1)
        return self.grid.centres(middles[wanted[tuple(middles.T)]])

    def patch_seen(self, middle_m: Floats) -> bool:
        """Return whether a square returned by `unseen_patches` has been seen since."""
        return not any((middle_m == other).all() for other in self.unseen_patches())

    def straight(self, start_m: Floats, end_m: Floats) -> bool:
        """Return whether the straight line between two points (2,) stays on open or visited cells."""
        return bool(self._in(self._passable, self.grid.line(start_m, end_m)).all())

    def ways_from(self, start_m: Floats) -> AreaWays:
        """Return the paths from a point (2,).

        Paths from a point too close to a shoal first lead back along the vehicle's track.
        """
        return AreaWays(self, self._passable, self.cells_of(start_m[None])[0][0])

    @property
    def _passable(self) -> NDArray[np.bool_]:
        """Return a mask of the cells that are open or that the vehicle has visited."""
        return (self._allowed & ~self._near) | (self._been & ~self._shoal)

    def cells_of(self, points_m: Floats) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """Return the cells (n, 2) of points (n, 2), and a mask (n,) of those inside the raster."""
        cells = self.grid.cells_of(points_m)
        return cells, self.grid.holds(cells)

    def _close(self, cells: NDArray[np.int64]) -> None:
        new = cells[~self._shoal[tuple(cells.T)]]
        if len(new):
            self._shoal[tuple(new.T)] = True
            near = (new[:, None] + self._disc).reshape(-1, 2)
            near = near[((near >= 0) & (near < self._near.shape)).all(axis=1)]
            self._near[tuple(near.T)] = True

    def _at(self, raster: NDArray[np.bool_], points_m: Floats) -> NDArray[np.bool_]:
        return self._in(raster, self.grid.cells_of(points_m))

    def _in(self, raster: NDArray[np.bool_], cells: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Return a raster's values at cells (n, 2), or False for cells outside it."""
        held = self.grid.holds(cells)
        found = np.zeros(len(cells), bool)
        found[held] = raster[tuple(cells[held].T)]
        return found


class AreaWays:
    """All shortest paths from one cell over the cells of a chart that were open when the paths were computed."""

    def __init__(self, chart: AreaChart, open_cells: NDArray[np.bool_], first: NDArray[np.int64]) -> None:
        self._chart = chart
        inside = np.clip(first, 0, np.array(open_cells.shape) - 1)
        self._ways = GridWays(np.where(open_cells, 1.0, np.inf), inside[None])

    def lengths_m(self, points_m: Floats) -> Floats:
        """Return the lengths (n,) of the paths to points (n, 2); inf where there is none."""
        cells, held = self._chart.cells_of(points_m)
        lengths = np.full(len(points_m), np.inf)
        lengths[held] = self._ways.costs[tuple(cells[held].T)]
        return np.asarray(lengths * self._chart.grid.edge_m)

    def to(self, goal_m: Floats) -> Floats | None:
        """Return the waypoints (n, 2) of a path from the first cell to a point (2,), or None if there is none."""
        (cell,), (held,) = self._chart.cells_of(goal_m[None])
        cells = self._ways.to(cell) if held else None
        if cells is None:
            return None
        return straightened(np.vstack([self._chart.grid.centres(cells), goal_m]), self._chart.straight)
