"""Builds the multibeam whose pings a recording contains, from the scenario in the recording."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from uwsim import _core
from uwsim.channels.families.map import empty_map
from uwsim.mapping import OccupancyMap
from uwsim.mapping.ping_to_map import PingToMap
from uwsim.recording.capsule import unpack
from uwsim.scenario import Scenario
from uwsim.scenario.build.multibeam import ping_chain
from uwsim.scenario.build.vehicle import vehicle_spec

if TYPE_CHECKING:
    from uwsim.recording.messages import Messages


@dataclass(frozen=True)
class RecordedHead:
    """A recorded multibeam.

    interval_s: the time between pings. prefix: the prefix of the vehicle's topics and frames. chain: the chain from its
    pings to a map.
    """

    model: _core.MultibeamModel
    interval_s: float
    prefix: str
    chain: PingToMap
    scenario: Scenario

    def new_map(self) -> OccupancyMap:
        """Return an empty map, like the one at the start of a live run of the scenario."""
        return empty_map(self.scenario)


def recorded_head(recording: Messages, topic: str, outlier_filter: bool | None = None) -> RecordedHead:
    """Return the multibeam for a channel of pings.

    outlier_filter: overrides the scenario's setting. Raises ValueError or OSError.
    """
    name, _, _ = topic.rpartition("/")
    # receives meshes that are no longer at their original path
    with tempfile.TemporaryDirectory(prefix="uwsim-head-") as folder:
        scenario = unpack(recording.attachments, Path(folder))
        entry = next(each for each in scenario.vehicles if each.model.sonar is not None and name in ("", each.name))
        model = vehicle_spec(scenario, entry).sonars[0].model
        return RecordedHead(
            model=model,
            interval_s=1.0 / (recording.channels[topic].rate_hz or 1.0),
            prefix="" if len(scenario.vehicles) == 1 else f"{entry.name}/",
            chain=ping_chain(
                scenario,
                entry.model,
                model,
                in_physics=entry.sonar.mode == "physics",
                outlier_filter=outlier_filter,
            ),
            scenario=scenario,
        )
