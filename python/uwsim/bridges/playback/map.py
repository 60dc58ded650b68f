"""PlayedMap: accumulates a recording's map changes for sinks that subscribe late."""

from __future__ import annotations

from typing import Any

from uwsim.channels.delivery.feed import Reading
from uwsim.channels.families.map_changes import MapChanges, Part
from uwsim.channels.ros import build
from uwsim.channels.ros.own_types import MAP_CHANGES


class PlayedMap:
    """The occupied voxels of a map as played so far. The map starts over when the recorded time jumps back."""

    def __init__(self) -> None:
        self._changes = MapChanges()
        self._header: Any = None
        self._time_ns = -1

    def apply(self, reading: Reading) -> None:
        """Apply the next message."""
        message = reading.message
        if reading.time_ns < self._time_ns:
            self._changes.forget(message.resolution)
        self._time_ns, self._header = reading.time_ns, message.header
        self._changes.apply(Part(*(getattr(message, name) for name in Part._fields)))

    def catch_up(self, cursor: Any) -> tuple[Any, Any]:
        """Return one message with all changes since a cursor (None: since the beginning), and the next cursor."""
        part, following = self._changes.since(cursor)
        header = {} if self._header is None else {"header": self._header}
        return build.message(MAP_CHANGES, **header, **part._asdict()), following
