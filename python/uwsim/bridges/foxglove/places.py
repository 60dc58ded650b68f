"""Where vehicles are, for their tracks: the truth, or over a link what their telemetry told."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from uwsim.bridges.foxglove.scenes import Positions
from uwsim.channels import Channel
from uwsim.channels.feed import Reading, Readings
from uwsim.channels.own_types import TELEMETRY
from uwsim.channels.table import table_of
from uwsim.live import LiveSimulator
from uwsim.simulator import Simulator

TRACK_S = 0.5

Follow = Callable[[Positions, int], object]
"""Takes positions, in the world frame, and when vehicles were there, in simulated nanoseconds."""
Leave = Callable[[], object]


def true_places(live: LiveSimulator) -> Callable[[Follow], Leave]:
    """Return what lets somebody follow where the vehicles are."""

    def listen(follow: Follow) -> Leave:
        def read(sim: Simulator) -> tuple[Positions, int]:
            found = {name: tuple(one.pose.position_world_m.tolist()) for name, one in sim.vehicles.items()}
            return found, sim.time_ns

        return live.every(TRACK_S, read, lambda found: follow(*found)).cancel

    return listen


def told_places(live: LiveSimulator, channels: Sequence[Channel], feed: Readings) -> Callable[[Follow], Leave]:
    """Return what lets somebody follow where the vehicles said they were: nowhere without `telemetry`."""
    said = [channel for channel in channels if channel.type == TELEMETRY]
    origin_m, names = table_of(live.simulator).origin_m, list(live.simulator.vehicles)

    def listen(follow: Follow) -> Leave:
        def take(reading: Reading) -> None:
            told = reading.message
            place = (told.true_position if told.is_truth else told.position) - origin_m
            name = reading.channel.name.rpartition("/")[0] or names[0]
            follow({name: tuple(place.tolist())}, reading.time_ns)

        leaves = [feed.listen(channel, take) for channel in said]
        return lambda: [leave() for leave in leaves]

    return listen
