"""Vehicles in deep water that another system steers: what tests of such bridges share."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from uwsim import Simulator
from uwsim.bridges.aboard.aboard import aboard_of
from uwsim.bridges.plug import BridgePlug, Context
from uwsim.channels.delivery.feed import Feed
from uwsim.channels.served import served_table
from uwsim.live import LiveSimulator
from uwsim.scenario import Scenario
from uwsim.scenario.read.validated import validated

OPEN_WATER: dict[str, Any] = {
    "name": "bay", "description": "deep water", "mission_time_s": 600,
    "water": {"density_kg_m3": 1026},
    "terrain": {"source": "noise", "size_m": [400, 400], "spacing_m": 10, "bed_depth_m": 60},
    "station": {"position_m": [-150, 0, 0], "dock_m": [0, 0, -2]},
    "earth": {"latitude_deg": 43.8253, "longitude_deg": -70.3304},
}  # fmt: skip


def bay(*vehicles: dict[str, Any], **more: Any) -> Scenario:
    return validated(Scenario, {**OPEN_WATER, **more, "vehicles": list(vehicles)})


def torpedo(name: str = "alpha", **start: Any) -> dict[str, Any]:
    return {"name": name, "model": "remus100", "start": {"position_m": [0, 0, -8], "yaw_deg": 90, **start}}


@contextmanager
def steered_by(plug: BridgePlug[Any], scenario: Scenario | str, speed: float = 1.0) -> Iterator[LiveSimulator]:
    """Run a scenario with a bridge open."""
    with LiveSimulator(Simulator(scenario, seed=3), speed=speed) as live:
        table = served_table(live, wire=None, origin="world", tf="truth", frame_prefix="")
        context = Context(table.channels, Feed(live), live, aboard=aboard_of(live.simulator, table))
        with plug.open(context):
            yield live
