"""The channels that a server offers for a live simulator."""

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
    """Return `channels`, the pace, and /clock with any wire, since clients are to use simulated time.

    On the wall clock, steps do not wait for pictures: the pace has priority. Single steps while paused do wait. Raises
    ValueError.
    """
    extra = [diagnostics_channel(live)]
    if wire == "published":
        extra = [channel for channel in channels(live.simulator) if channel.name == "clock"]
    watched = ref(live)  # the table is kept with its simulator and must not keep it alive

    def may_wait() -> bool:
        live = watched()
        return live is None or live.speed == "max" or live.paused

    return [*extra, *channels(live.simulator, wire=wire, origin=origin, may_wait=may_wait, truth=truth)]
