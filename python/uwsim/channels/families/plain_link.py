"""The `link` channel of a scenario without a link, which reports whether a fault has cut off the vehicle."""

from __future__ import annotations

from typing import Any

from uwsim.channels.authority.steering import is_cut_off
from uwsim.channels.channel import Channel
from uwsim.channels.ros import build
from uwsim.channels.ros.own_types import LINK
from uwsim.channels.source import Source
from uwsim.simulator.simulator import Simulator

RATE_HZ = 2.0
NONE = "none"


def plain_link_channels(source: Source, sim: Simulator) -> list[Channel]:
    """Return the channel in a list. The list is empty if the scenario has a link, which has its own channel."""
    if sim.link is not None:
        return []

    def read(sim: Simulator) -> Any:
        is_down = is_cut_off(sim, source.name)
        header = build.header(sim.time_ns, "")
        return build.message(LINK, header=header, modem=NONE, quality=float(not is_down), fault_loss=float(is_down))

    return [
        Channel(
            source.topic("link"), LINK, "out", "whether anything passes between the station and the vehicle: no link, "
            "but a fault may have cut it off", rate_hz=RATE_HZ, read=read,
        )
    ]  # fmt: skip
