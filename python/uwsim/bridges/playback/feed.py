"""PlayedFeed: forwards a recording's messages to bridges, as Feed forwards a live simulator's readings."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

from uwsim.channels import Channel, Delivery
from uwsim.channels.delivery.feed import Reading, Sink
from uwsim.channels.families.map_changes import MapChanges, Part
from uwsim.channels.ros import build
from uwsim.channels.ros.own_types import MAP_CHANGES
from uwsim.recording.commands import COMMANDS
from uwsim.recording.mcap_sink import is_latched
from uwsim.recording.messages import Recorded
from uwsim.recording.reader import Recording

logger = logging.getLogger("uwsim.bridges")


def channels_of(recording: Recording) -> list[Channel]:
    """Return a recording's channels for bridges: all channels except commands, plus received and derived ones."""
    found = []
    for info in (*recording.channels.values(), *recording.derived.values()):
        if info.name != COMMANDS:
            about = recording.metadata(info.name)
            description, latched = about.get("description", ""), is_latched(about)
            found.append(
                Channel(info.name, info.type, "out", description, rate_hz=info.rate_hz, delivery=Delivery(latched))
            )
    return found


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


class PlayedFeed:
    """Readings that contain the recorded bytes unchanged. Sinks are called on the playback thread.

    channels: the channels to play, keyed by name. A sink that subscribes late to a map's changes receives all earlier
    changes.
    """

    def __init__(self, channels: Iterable[Channel] = ()) -> None:
        self.channels: dict[str, Channel] = {}
        self._maps: dict[str, PlayedMap] = {}
        for channel in channels:
            if channel.type == MAP_CHANGES:
                grown = self._maps[channel.name] = PlayedMap()
                channel = replace(channel, delivery=replace(channel.delivery, catch_up=grown.catch_up))
            self.channels[channel.name] = channel
        self._lock = threading.Lock()
        self._sinks: dict[str, tuple[Sink, ...]] = {}
        self._newest: dict[str, Reading] = {}
        self._clocks: dict[object, _Clock] = {}

    @property
    def is_wanted(self) -> bool:
        """Whether any sink is listening."""
        return any(self._sinks.values())

    def listen(self, channel: Channel, sink: Sink) -> Callable[[], None]:
        """Pass each reading of a channel to a sink from now on; return a function that unsubscribes it.

        A latched channel's latest reading is passed immediately.
        """
        with self._lock:
            self._sinks[channel.name] = (*self._sinks.get(channel.name, ()), sink)
            newest = self._late(channel)
        if newest is not None:
            sink(newest)
        return lambda: self._leave(channel.name, sink)

    def newest(self, channel: Channel) -> Reading | None:
        """Return a latched channel's latest reading, or all readings combined if the messages build on each other."""
        with self._lock:
            return self._late(channel)

    def _late(self, channel: Channel) -> Reading | None:
        newest = self._newest.get(channel.name)
        return newest if newest is None or channel.name not in self._maps else newest.caught_up()

    def listen_time(self, period_s: float, sink: Callable[[int], object]) -> Callable[[], None]:
        """Report the recorded time [ns] to a sink once per recorded period; return a function that stops it."""
        key = object()
        self._clocks[key] = _Clock(round(1e9 * period_s), sink)

        def end() -> None:
            self._clocks.pop(key, None)

        return end

    def play(self, channel: Channel, recorded: Recorded) -> Reading:
        """Pass a message to all sinks, and return it as a reading."""
        reading = Reading(channel, None, recorded.time_ns, 0, cdr=memoryview(recorded.data))
        if channel.name in self._maps:
            self._maps[channel.name].apply(reading)
        with self._lock:
            sinks = self._sinks.get(channel.name, ())
            if channel.delivery.latched:
                self._newest[channel.name] = reading
        for clock in list(self._clocks.values()):
            clock.pass_to(recorded.time_ns)
        for sink in sinks:
            try:
                sink(reading)
            except Exception:
                logger.exception("channel '%s': a sink failed", channel.name)
        return reading

    def _leave(self, name: str, sink: Sink) -> None:
        with self._lock:
            self._sinks[name] = tuple(kept for kept in self._sinks[name] if kept is not sink)


class _Clock:
    """Reports the recorded time whenever it passes a multiple of a period, in either direction."""

    def __init__(self, period_ns: int, sink: Callable[[int], object]) -> None:
        self._period_ns = period_ns
        self._sink = sink
        self._last: int | None = None

    def pass_to(self, time_ns: int) -> None:
        """Report the time if a report is due."""
        if time_ns // self._period_ns != self._last:
            self._last = time_ns // self._period_ns
            self._sink(time_ns)
