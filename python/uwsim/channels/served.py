"""The table of channels that a server offers for a live simulator."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from uwsim.channels.families.diagnostics import diagnostics_channel
from uwsim.channels.families.frames import Tf, clock_channel
from uwsim.channels.table import Table, Wire
from uwsim.live import LiveSimulator
from uwsim.scenario import Scenario


def default_origin(scenario: Scenario) -> str:
    """Return the name of the origin that a scenario's server uses by default."""
    return "published" if scenario.wire == "published" else "world"


def served_table(
    live: LiveSimulator,
    *,
    wire: Wire | None = None,
    origin: str | Sequence[float] | None = None,
    truth: bool = True,
    tf: Tf = "truth",
    frame_prefix: str = "",
    waits_at_full_speed: bool = True,
    **options: Any,
) -> Table:
    """Return the table of channels, plus /diagnostics and, because clients use simulated time, /clock.

    wire, origin: by default the scenario's. In real time, steps do not wait for pictures, since keeping pace is more
    important. Steps that a client requests while the simulator is paused do wait, and those at full speed do if
    waits_at_full_speed. options: more of Table's. Raises
    ValueError.
    """

    def may_wait() -> bool:
        return live.paused or (waits_at_full_speed and live.speed == "max")

    scenario = live.simulator.scenario
    wire = scenario.wire if wire is None else wire
    origin = default_origin(scenario) if origin is None else origin
    table = Table(
        live.simulator,
        wire=wire,
        origin=origin,
        may_wait=may_wait,
        is_behind=lambda: live.is_behind,
        truth=truth,
        tf=tf,
        frame_prefix=frame_prefix,
        **options,
    )
    table.channels.insert(
        0, clock_channel() if wire == "published" else diagnostics_channel(live, lambda: table.channels)
    )
    return table
