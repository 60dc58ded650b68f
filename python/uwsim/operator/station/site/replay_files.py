"""Files that the page draws in a replay: the track of the flight, and another flight's track and hull."""

from __future__ import annotations

import json

from uwsim.operator.station.flights.flights import track
from uwsim.operator.station.flights.replay import Replay
from uwsim.operator.station.sessions.running import Running


def track_json(running: Running) -> bytes:
    """Return the track of the flight being replayed: `{times_s, poses}`, in odom. Raises ValueError."""
    return json.dumps(track(_replay(running).timeline, running.table.origin_m)).encode()


def ghost_json(running: Running, name: str) -> bytes:
    """Return another flight's track and its distance: `{flight, track, times_s, apart_m}`. Raises ValueError."""
    replay = _replay(running)
    return json.dumps(replay.flights.ghost(replay.timeline, name, running.table.origin_m)).encode()


def hull_glb(running: Running, name: str) -> bytes:
    """Return the hull of another flight's first vehicle as GLB, in body axes. Raises ValueError."""
    return _replay(running).flights.hull(name)


def _replay(running: Running) -> Replay:
    if running.replay is None:
        raise ValueError("no flight is replayed")
    return running.replay
