"""The channels of a simulator as seen from the station, through the link."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from uwsim.channels import Channel
from uwsim.channels.ros.own_types import LINK
from uwsim.channels.table import Table
from uwsim.link.ashore import OnRead, maps_ashore
from uwsim.link.carried import Carried, carried_channels
from uwsim.link.status import status_channels
from uwsim.simulator.network import STATION, Network
from uwsim.simulator.simulator import Simulator

MODEM_HZ, QUICK_HZ = 20.0, 100.0
"""How often the station checks for arrivals, in simulated time: messages appear up to one period later."""


def seen_channels(
    sim: Simulator, table: Table, given: Iterable[Channel] | None = None, on_read: OnRead | None = None
) -> list[Channel]:
    """Return a table's channels as seen at the station, where channels that cross the link deliver arrived messages.

    Channels that could go over the link but are not carried are left out; maps, including the table's own, are built
    ashore. Messages depend only on the simulator's state, so that a replay reads the same messages. given: the table's
    channels to consider, by default all. on_read: called each time that a channel is read.
    """
    network = sim.link
    given = list(table.channels if given is None else given)
    if network is None:
        return given
    carried = {one.channel.name: one for one in carried_channels(given, sim)}
    seen = []
    for channel in maps_ashore(table, network, given, carried, on_read):
        one = carried.get(channel.name)
        if one is not None:
            seen.append(_seen(one, network, on_read) if channel.direction == "out" else channel)
        elif not channel.over_link:
            seen.append(channel)
    return seen + status_channels(sim, network)


def is_seen(sim: Simulator, channels: Iterable[Channel]) -> bool:
    """Return whether channels are a station's, which result from `seen_channels`."""
    return sim.link is not None and any(channel.type == LINK for channel in channels)


def _seen(one: Carried, network: Network, on_read: OnRead | None) -> Channel:
    rate_hz = MODEM_HZ if network.modem.kind == "modem" else QUICK_HZ
    name = one.channel.name

    def read(sim: Simulator) -> Any:
        if on_read is not None:
            on_read(name, sim)
        found = [got for got in network.received(STATION, sim.time_s - 1.0 / rate_hz) if got.topic == name]
        return one.packing.unpack(found[-1].payload, one.channel) if found else None

    delivery = replace(one.channel.delivery, late=False, update=None, catch_up=None)
    return replace(one.channel, rate_hz=rate_hz, read=read, taped=None, delivery=delivery)
