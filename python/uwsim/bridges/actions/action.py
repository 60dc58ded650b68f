"""Action: one entry of the table of actions."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim.channels.names import checked_namespace
from uwsim.channels.source import Source
from uwsim.channels.steering import Steering


class Route(NamedTuple):
    """Where to fly. points_world_m: (n, 3). heading_rad: at the end, from east; None: any."""

    points_world_m: NDArray[np.float64]
    speed_m_s: float
    heading_rad: float | None


class Progress(NamedTuple):
    """The state of a flight.

    pose: a geometry_msgs/PoseStamped. leg: index of the point ahead. remaining_m: along the legs. elapsed_s: simulated
    time since the start.
    """

    pose: Any
    leg: int
    remaining_m: float
    elapsed_s: float


@dataclass(frozen=True, eq=False)
class Action:
    """An action of one vehicle.

    name: without a leading slash. type: in ACTION_TYPES. uses_truth: whether it flies by the true pose instead of the
    estimate, like /tf. route: reads a goal, a message; raises ValueError. feedback: returns the message for a state.
    result: returns the message for a flight that ended after a time [s], for a reason if it ended early, else "".
    """

    name: str
    type: str
    description: str
    source: Source
    steering: Steering
    uses_truth: bool
    route: Callable[[Any], Route]
    feedback: Callable[[Progress], Any]
    result: Callable[[float, str], Any]


def actions_in(namespace: str, actions: Iterable[Action]) -> list[Action]:
    """Return actions with their names in a namespace; "" changes none. Raises ValueError."""
    plain = checked_namespace(namespace)
    return [replace(action, name=f"{plain}/{action.name}") if plain else action for action in actions]
