"""The extent of a flight: its map as it grows, the bed that it has seen, its lanes, and the area that is scored."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.base.polygon import inside
from uwsim.mapping import OccupancyMap
from uwsim.missions.lanes import LANE_FLOWN, LANES_FLOWN, flown_text
from uwsim.missions.own_vehicle import Event
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


CELL_M, PERIOD_S = 1.0, 1.0


class SeenBed:
    """Pings once a second from each vehicle's current pose, as an Observer of the simulator's journal.

    Echoes count at their true positions, regardless of the vehicles' estimates. times_s: times since the start.
    areas_m2: the area seen by then. cells: all columns with an echo.
    """

    def __init__(self, sim: Simulator, vehicles: Iterable[str]) -> None:
        self._sim, self._vehicles = sim, [sim.vehicles[name] for name in vehicles]
        self._steps = max(1, round(PERIOD_S / sim.step_s))
        self._start_s = sim.time_s
        self.due_tick = sim.tick + self._steps
        self.cells: set[tuple[int, int]] = set()
        self.times_s: list[float] = []
        self.areas_m2: list[float] = []

    def observe(self) -> None:
        """Take a ping with each vehicle and add the columns seen."""
        self.due_tick = self._sim.tick + self._steps
        for vehicle in self._vehicles:
            if vehicle.released:
                ping = vehicle.sonar.ping()
                points = ping.points_sonar_m[np.isfinite(ping.ranges_m)] @ ping.world_from_sonar[:2, :3].T
                columns = np.unique(np.floor((points + ping.world_from_sonar[:2, 3]) / CELL_M).astype(np.int64), axis=0)
                self.cells.update((i, j) for i, j in columns.tolist())
        self.times_s.append(self._sim.time_s - self._start_s)
        self.areas_m2.append(len(self.cells) * CELL_M**2)


class LanesFlown(NamedTuple):
    """Planned lanes, and how much of them was flown. lanes: their number. each: every lane that was begun or given up.

    An item of `each` has vehicle, number, flown_m, planned_m and, for a lane cut short, because.
    """

    lanes: int
    flown_m: float
    planned_m: float
    each: list[dict[str, Any]]

    @property
    def cut_short(self) -> list[dict[str, Any]]:
        """The items of lanes that were cut short."""
        return [lane for lane in self.each if "because" in lane]

    def rows(self) -> list[tuple[str, str]]:
        """Return rows of (name, value with unit) for tables."""
        percent, _, lengths = flown_text(self.flown_m, self.planned_m).partition(" of the planned lanes ")
        rows = [("lanes flown", f"{lengths.strip('()')}, {percent}")]
        return [*rows, ("lanes cut short", f"{len(cut)} of {self.lanes}")] if (cut := self.cut_short) else rows


def lanes_flown(events: Iterable[Event]) -> LanesFlown | None:
    """Return what the missions of a log flew of their lanes; None if none flew lanes."""
    events = list(events)
    totals = [event.values for event in events if event.name == LANES_FLOWN]
    if not totals:
        return None
    each = [{"vehicle": event.vehicle, **event.values} for event in events if event.name == LANE_FLOWN]
    lanes, flown_m, planned_m = (sum(total[key] for total in totals) for key in ("lanes", "flown_m", "planned_m"))
    return LanesFlown(lanes, flown_m, planned_m, each)


AREA_MARGIN_M = 5.0


def scored_area_m(survey_area_m: Floats | None, path_world_m: Floats) -> Floats | None:
    """Return the polygon (k, 2) in which the map of a flight is scored; None if there is none.

    path_world_m: the positions (n, 3) at which its pings were taken.

    It is the scenario's survey area or, if there is no survey or no ping was taken over its area, the area around the
    sonar positions; see flown_area_m.
    """
    if survey_area_m is not None:
        is_over = not len(path_world_m) or inside(path_world_m[:, :2], survey_area_m).any()
        if is_over:
            return survey_area_m
    return flown_area_m(path_world_m)


def flown_area_m(path_world_m: Floats) -> Floats | None:
    """Return the convex hull (k, 2) of positions (n, 3), enlarged by AREA_MARGIN_M; None if there are no positions."""
    if not len(path_world_m):
        return None
    from scipy.spatial import ConvexHull, QhullError  # here, since scipy is slow to import

    angles = np.radians(np.arange(0.0, 360.0, 22.5))
    ring = AREA_MARGIN_M * np.column_stack([np.cos(angles), np.sin(angles)])
    places = np.unique(path_world_m[:, :2].round(2), axis=0)
    with suppress(QhullError, ValueError):  # fewer than three positions, or all collinear
        places = places[ConvexHull(places).vertices]
    around = (places[:, None] + ring).reshape(-1, 2)
    return np.asarray(around[ConvexHull(around).vertices], np.float64)
