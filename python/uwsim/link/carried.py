"""Determines which channels go over a link, to which vehicle they belong, and how they are packed."""

from __future__ import annotations

import fnmatch
from collections.abc import Iterable
from typing import NamedTuple

from uwsim.channels import Channel
from uwsim.link.packing import Packing, packing_of
from uwsim.simulator.simulator import Simulator


class Carried(NamedTuple):
    """A channel that goes over the link between the station and a vehicle."""

    channel: Channel
    vehicle: str
    packing: Packing
    priority: int


def vehicle_of(channel: Channel, sim: Simulator) -> str | None:
    """Return the vehicle to which a channel belongs, according to its prefix; None if it belongs to several."""
    names = list(sim.vehicles)
    if len(names) == 1:
        return names[0]
    first = channel.name.split("/", 1)[0]
    return first if first in names and "/" in channel.name else None


def carried_channels(channels: Iterable[Channel], sim: Simulator) -> list[Carried]:
    """Return the channels that the scenario's link carries.

    The link does not carry channels that belong to several vehicles.
    """
    network, setup = sim.link, sim.scenario.link
    if network is None or setup is None:
        return []
    found = []
    for channel in channels:
        packing = packing_of(channel, network.modem)
        vehicle = vehicle_of(channel, sim)
        if channel.over_link and packing and vehicle and is_chosen(channel.name, setup.carries):
            found.append(Carried(channel, vehicle, packing, channel.over_link.priority))
    return found


def is_chosen(name: str, patterns: Iterable[str]) -> bool:
    """Return whether any of the patterns matches a channel's name."""
    return any(fnmatch.fnmatchcase(name, pattern.removeprefix("/")) for pattern in patterns)
