"""The map that a live run made, from its recording alone: the bytes of its /octomap_binary and save_map."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

from uwsim import _core
from uwsim.channels.map import empty_map, hull_box_m, mapped_points
from uwsim.mapping import OccupancyMap
from uwsim.recording.capsule import unpack
from uwsim.recording.pings import ping_topic, recorded_pings
from uwsim.recording.reader import Recording
from uwsim.scenario.build.vehicle import vehicle_spec


@dataclass(frozen=True)
class RecordedHead:
    """The multibeam whose pings were recorded."""

    model: _core.MultibeamModel
    interval_s: float


def live_map(recording: Recording, vehicle: str | None = None) -> tuple[OccupancyMap, int]:
    """Return the map in odom of a vehicle's pings since the last jump of time, and their number. Raises ValueError."""
    topic = ping_topic(recording, vehicle)
    with tempfile.TemporaryDirectory(prefix="uwsim-map-") as folder:
        scenario = unpack(recording.attachments, Path(folder))
        name, _, _ = topic.rpartition("/")
        entry = next(each for each in scenario.vehicles if each.model.sonar is not None and name in ("", each.name))
        head = RecordedHead(
            vehicle_spec(scenario, entry).sonars[0].model, 1.0 / (recording.channels[topic].rate_hz or 1.0)
        )
        hull = hull_box_m(entry.model)
    occupancy, newest_ns, count = empty_map(scenario), -1, 0
    for taken, _ in recorded_pings(recording, topic):
        stamp_ns = taken.ping.time_ns
        if stamp_ns == newest_ns:
            continue
        if stamp_ns < newest_ns:
            occupancy, count = empty_map(scenario), 0
        newest_ns, count = stamp_ns, count + 1
        occupancy.insert_scan(mapped_points(head, taken, hull), taken.odom_from_sonar[:3, 3], head.model.range_max_m)
    return occupancy, count
