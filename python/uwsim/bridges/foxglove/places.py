"""Provides vehicle positions for the tracks: those in telemetry, which the vehicles measure, and the true ones."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from uwsim.bridges.foxglove.scenes import Positions
from uwsim.channels import Channel
from uwsim.channels.delivery.feed import Reading, Readings
from uwsim.channels.families.published import TRUE_TOPICS
from uwsim.channels.ros.own_types import TELEMETRY
from uwsim.live import LiveSimulator
from uwsim.simulator.simulator import Simulator

TRACK_S = 0.5
Vector = NDArray[np.float64]
ORIGIN_M: Vector = np.zeros(3)

Follow = Callable[[Positions, int], object]
"""Receives positions in the world frame and their simulated time [ns]."""
Leave = Callable[[], object]


def publish_truth(channels: Sequence[Channel]) -> bool:
    """Return True if the vehicles' true motion is among the channels."""
    return any(channel.name.endswith(("ground_truth/odom", *TRUE_TOPICS)) for channel in channels)


def true_places(live: LiveSimulator) -> Callable[[Follow], Leave]:
    """Return a function that starts forwarding the vehicles' true positions."""

    def listen(follow: Follow) -> Leave:
        def read(sim: Simulator) -> tuple[Positions, int]:
            found = {name: tuple(one.pose.position_world_m.tolist()) for name, one in sim.vehicles.items()}
            return found, sim.time_ns

        return live.every(TRACK_S, read, lambda found: follow(*found)).cancel

    return listen


def received_places(
    live: LiveSimulator, channels: Sequence[Channel], feed: Readings, origin_m: Vector = ORIGIN_M
) -> Callable[[Follow], Leave]:
    """Return a function that starts forwarding the vehicles' own positions, as telemetry has them.

    origin_m: the world's origin in odom.
    """
    panels = [channel for channel in channels if channel.type == TELEMETRY]
    names = list(live.simulator.vehicles)

    def listen(follow: Follow) -> Leave:
        def take(reading: Reading) -> None:
            place = reading.message.position - origin_m
            name = reading.channel.name.rpartition("/")[0] or names[0]
            follow({name: tuple(place.tolist())}, reading.time_ns)

        leaves = [feed.listen(channel, take) for channel in panels]
        return lambda: [leave() for leave in leaves]

    return listen
