"""The channels that a server offers for a live simulator."""

from __future__ import annotations

from collections.abc import Sequence

from uwsim.channels.diagnostics import diagnostics_channel
from uwsim.channels.frames import clock_channel
from uwsim.channels.table import Table, Wire
from uwsim.live import LiveSimulator


def served_table(
    live: LiveSimulator, *, wire: Wire = "both", origin: str | Sequence[float] = "world", truth: bool = True
) -> Table:
    """Return a table, the pace, and /clock with any wire, since clients are set to use simulated time.

    On the wall clock steps do not wait for pictures, since the pace comes first. While paused, the steps that a client
    requests do wait. Raises ValueError.
    """

    def may_wait() -> bool:
        return live.speed == "max" or live.paused

    table = Table(live.simulator, wire=wire, origin=origin, may_wait=may_wait, truth=truth)
    table.channels.insert(0, clock_channel() if wire == "published" else diagnostics_channel(live))
    return table
