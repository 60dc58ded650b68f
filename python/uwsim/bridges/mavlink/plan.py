"""The flights that a MAVLink vehicle makes by itself: an uploaded mission, and the way to the surface."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.bridges.actions.action import NEAR, Tolerance
from uwsim.bridges.mavlink.craft import Craft
from uwsim.bridges.mavlink.servos import Servos
from uwsim.missions import OwnVehicle, Steps
from uwsim.missions.items import SURFACE_M, Pilot, fly_items
from uwsim.missions.moves import reached_m, surface


class MissionPlan:
    """The flight of a mission from one of its items on. begun, reached: called with each item's sequence number.

    points_world_m: the last waypoint, where the vehicle stays at the end of the mission.
    """

    points_world_m: NDArray[np.float64] = np.empty((0, 3))
    heading_rad: float | None = None

    def __init__(
        self, items: Iterable[Any], first: int, craft: Craft, servos: Servos,
        begun: Callable[[int], object], reached: Callable[[int], object],
    ) -> None:  # fmt: skip
        self._items, self._first = list(items)[1:], first
        self._craft, self._servos, self._begun, self._reached = craft, servos, begun, reached
        if not self._items:
            raise ValueError("there is no mission: upload one")

    def steps(self, vehicle: OwnVehicle, begin: Callable[[int], object], tolerance: Tolerance = NEAR) -> Steps[None]:
        """Fly the items in turn."""
        pilot = Pilot(vehicle, self._craft, self._servos, reached_m(vehicle, tolerance.xy_m))
        yield from fly_items(pilot, self._items, self._first, self._begun, self._reached)
        if pilot.passed is not None:
            self.points_world_m = pilot.passed.reshape(1, 3)


class Ascent:
    """A flight to the surface, as of ArduSub's mode SURFACE."""

    points_world_m: NDArray[np.float64] = np.empty((0, 3))
    heading_rad: float | None = None

    def steps(self, vehicle: OwnVehicle, begin: Callable[[int], object], tolerance: Tolerance = NEAR) -> Steps[None]:
        """Rise on the spot."""
        yield from surface(vehicle, within_m=SURFACE_M)
