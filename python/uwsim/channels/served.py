"""What a server tells its clients about a live simulator."""

from __future__ import annotations

from collections.abc import Sequence
from weakref import ref

from uwsim.channels.channel import Channel
from uwsim.channels.diagnostics import diagnostics_channel
from uwsim.channels.table import Wire, channels
from uwsim.live import LiveSimulator


def served_channels(
    live: LiveSimulator, *, wire: Wire = "both", origin: str | Sequence[float] = "world", truth: bool = True
) -> list[Channel]:
    """Return `channels`, the pace, and /clock with any wire, for clients are told to use simulated time.

    On the wall clock steps do not wait for pictures: the pace comes first. Steps that are asked for while it is paused
    do. Raises ValueError.
    """
    extra = [diagnostics_channel(live)]
    if wire == "published":
        extra = [channel for channel in channels(live.simulator) if channel.name == "clock"]
    watched = ref(live)  # the table of a simulator lives as long as that: it must not keep it alive

    def may_wait() -> bool:
        live = watched()
        return live is None or live.speed == "max" or live.paused

    return [*extra, *channels(live.simulator, wire=wire, origin=origin, may_wait=may_wait, truth=truth)]
