"""Rebuilds the map of a live run from its recording alone, byte for byte as in /octomap_binary and save_map."""

from __future__ import annotations

from uwsim.channels.families.map import insert_ping
from uwsim.mapping import OccupancyMap
from uwsim.recording.head import recorded_head
from uwsim.recording.pings import ping_topic, recorded_pings
from uwsim.recording.reader import Recording


def live_map(
    recording: Recording, vehicle: str | None = None, *, outlier_filter: bool | None = None
) -> tuple[OccupancyMap, int]:
    """Return the map, in odom, of a vehicle's pings since the last jump in time, and the number of pings.

    outlier_filter: overrides the scenario's setting. Raises ValueError.
    """
    topic = ping_topic(recording, vehicle)
    head = recorded_head(recording, topic, outlier_filter)
    occupancy, newest_ns, count = head.new_map(), -1, 0
    for taken, _ in recorded_pings(recording, topic):
        stamp_ns = taken.ping.time_ns
        if stamp_ns == newest_ns:
            continue
        if stamp_ns < newest_ns:
            occupancy, count = head.new_map(), 0
        newest_ns, count = stamp_ns, count + 1
        insert_ping(occupancy, head, taken)
    return occupancy, count
