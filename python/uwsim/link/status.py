"""The `link` channel, which reports how well a vehicle and the station receive each other."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from uwsim.channels import Channel
from uwsim.channels.ros import build
from uwsim.channels.ros.own_types import LINK
from uwsim.simulator.network import STATION, Network
from uwsim.simulator.simulator import Simulator

RATE_HZ = 2.0


def status_channels(sim: Simulator, network: Network) -> list[Channel]:
    """Return a channel for each vehicle. These channels are meant for observers and do not go over the link."""
    alone = len(sim.vehicles) == 1
    return [
        Channel(
            "link" if alone else f"{name}/link", LINK, "out", "the link to the station: quality, delay, queue, counts",
            rate_hz=RATE_HZ, read=_reader(network, name),
        )
        for name in sim.vehicles
    ]  # fmt: skip


def _reader(network: Network, vehicle: str) -> Callable[[Simulator], Any]:
    def read(sim: Simulator) -> Any:
        up, down = network.quality(vehicle, STATION), network.quality(STATION, vehicle)
        counts = [one for one in network.counts() if one.sender in (vehicle, STATION)]
        latest = up if up.heard_ns >= down.heard_ns else down
        packets = up.packets + down.packets
        return build.message(
            LINK,
            header=build.header(sim.time_ns, ""),
            modem=network.modem.name,
            quality=1.0 - (up.packets_lost + down.packets_lost) / packets if packets else 1.0,
            delay=latest.delay_s if latest.packets else math.nan,
            snr=latest.snr_db if latest.packets and network.modem.kind == "modem" else math.nan,
            closing_speed=latest.closing_m_s,
            silence=network.silence_s(vehicle),
            silence_at_station=network.silence_s(STATION, vehicle),
            queue_station=network.waiting(STATION)[1],
            queue_vehicle=network.waiting(vehicle)[1],
            sent=sum(one.sent for one in counts),
            delivered=sum(one.delivered for one in counts),
            lost=sum(sum(one.lost.values()) for one in counts),
            late=sum(one.late + one.refused for one in counts),
            bytes_delivered=sum(one.bytes_delivered for one in counts),
            fault_loss=network.fault_loss(vehicle),
        )

    return read
