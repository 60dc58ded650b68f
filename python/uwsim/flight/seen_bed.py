"""Measures how much of the bed and its objects a flight sees over time, by counting 1 m x 1 m columns with an echo."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from uwsim.simulator.simulator import Simulator

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
