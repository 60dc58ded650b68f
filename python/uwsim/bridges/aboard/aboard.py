"""Vehicles for systems aboard them."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from uwsim.channels import Channel, Table
from uwsim.channels.authority.steering import Steering
from uwsim.channels.families.estimate import has_estimate
from uwsim.channels.families.scans import scan_channels
from uwsim.channels.source import Source
from uwsim.simulator.simulator import Simulator


class Aboard(NamedTuple):
    """A vehicle as a system aboard it meets it, whether or not a link lies between it and the station.

    steering: the door to its own helm. scan: the channel of its sonar's pings, or None.
    """

    source: Source
    steering: Steering
    scan: Channel | None


def aboard_of(sim: Simulator, table: Table) -> dict[str, Aboard]:
    """Return the vehicles that a system aboard can steer, by name: those that have an estimate to steer by."""
    found: dict[str, Aboard] = {}
    for source in table.sources:
        if not (table.tf == "truth" or has_estimate(source)):
            continue
        steering, scan, topic = table.steering[source.name], None, source.topic("scan")
        if source.name in table.pings:
            scan = next(each for each in scan_channels(source, table.pings[source.name]) if each.name == topic)
        if sim.link is not None:  # peers have a door ashore, and the pings that have arrived there
            helm = source.of(sim).helm
            steering = Steering(source, table.rights, helm, helm)
            scan = None if scan is None else replace(scan, name=source.topic("aboard/scan"))
        found[source.name] = Aboard(source, steering, scan)
    return found
