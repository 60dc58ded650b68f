"""Action: one entry of the table of actions."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from uwsim.channels.authority.steering import Steering
from uwsim.channels.names import checked_namespace
from uwsim.channels.source import Source
from uwsim.missions import OwnVehicle, Steps, goto, turn_to
from uwsim.missions.moves import REACHED_IN_PASSING_M, REACHED_M, can_stand, follow_leg, reached_m


class Tolerance(NamedTuple):
    """How near to a target it counts as reached: a distance [m] and an angle [rad]. See VehicleEntry."""

    xy_m: float = REACHED_M
    yaw_rad: float = 0.05


NEAR = Tolerance()


class Plan(Protocol):
    """The course of a flight."""

    @property
    def points_world_m(self) -> NDArray[np.float64]:
        """The points to fly to, (n, 3), to measure what remains. The vehicle is held at the last one afterwards."""
        ...

    @property
    def heading_rad(self) -> float | None:
        """The heading at the end, from east; None for any."""
        ...

    def steps(self, vehicle: OwnVehicle, begin: Callable[[int], object], tolerance: Tolerance = NEAR) -> Steps[None]:
        """Fly it. begin: called with the index of each point after the first, once the vehicle flies to it."""
        ...


class Route(NamedTuple):
    """A route to fly. points_world_m: (n, 3). heading_rad: the final heading, from east; None for any."""

    points_world_m: NDArray[np.float64]
    speed_m_s: float
    heading_rad: float | None

    def steps(self, vehicle: OwnVehicle, begin: Callable[[int], object], tolerance: Tolerance = NEAR) -> Steps[None]:
        """Fly straight legs to the last point, and turn there. It ends at the point and heading, within tolerance."""
        points, speed_m_s, within_m = self.points_world_m, self.speed_m_s, reached_m(vehicle, tolerance.xy_m)
        if len(points) > 1:
            yield from goto(vehicle, points[0], speed_m_s=speed_m_s, within_m=max(within_m, REACHED_IN_PASSING_M))
            for leg, (start, end) in enumerate(pairwise(points), start=1):
                begin(leg)
                yield from follow_leg(vehicle, start, end, speed_m_s=speed_m_s)
        yield from goto(vehicle, points[-1], speed_m_s=speed_m_s, within_m=within_m)
        if self.heading_rad is not None:
            yield from turn_to(vehicle, self.heading_rad, within_rad=tolerance.yaw_rad)
            if can_stand(vehicle):  # it drifts while it turns
                yield from goto(
                    vehicle, points[-1], heading_rad=self.heading_rad, speed_m_s=speed_m_s, within_m=within_m
                )


class Progress(NamedTuple):
    """The state of a flight.

    pose: a geometry_msgs/PoseStamped. leg: index of the next point. remaining_m: distance along the legs. elapsed_s:
    simulated time since the start.
    """

    pose: Any
    leg: int
    remaining_m: float
    elapsed_s: float


@dataclass(frozen=True, eq=False)
class Offered:
    """An action of one vehicle. name: without a leading slash. type: a key of ACTION_TYPES."""

    name: str
    type: str
    description: str
    source: Source
    steering: Steering


@dataclass(frozen=True, eq=False)
class Action(Offered):
    """A flight.

    uses_truth: whether flights use the true pose, like /tf,
    instead of the estimate. route: converts a goal message to a plan; raises ValueError. feedback: builds the message
    for a Progress. result: builds the message from the duration of the flight [s] and the reason for an early end (""
    for none).
    """

    uses_truth: bool
    route: Callable[[Any], Plan]
    feedback: Callable[[Progress], Any]
    result: Callable[[float, str], Any]


def actions_in(namespace: str, actions: Iterable[Offered]) -> list[Offered]:
    """Return the actions with their names moved to a namespace; "" changes nothing. Raises ValueError."""
    plain = checked_namespace(namespace)
    return [replace(action, name=f"{plain}/{action.name}") if plain else action for action in actions]
