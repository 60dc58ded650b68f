"""Feed: reads a live simulator's channels once for all sinks, and encodes each reading once."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from typing import Any, Protocol

from uwsim.channels.channel import Channel
from uwsim.channels.ros.cdr import encode
from uwsim.channels.ros.messages import from_bytes
from uwsim.live import LiveSimulator
from uwsim.simulator.simulator import Simulator

logger = logging.getLogger("uwsim.channels")


class Reading:
    """One message from a channel. time_ns, tick: the simulated time at which it was read, also in steps."""

    __slots__ = ("_cdr", "_lock", "_make", "_message", "channel", "tick", "time_ns")

    def __init__(
        self,
        channel: Channel,
        message: Any,
        time_ns: int,
        tick: int,
        *,
        cdr: memoryview | None = None,
        make: Callable[[], Any] | None = None,
    ) -> None:
        """message: None if `cdr` holds the encoded message, or if `make` builds the message on first access."""
        self._make = make
        self.channel = channel
        self.time_ns = time_ns
        self.tick = tick
        self._message = message
        self._cdr = cdr
        self._lock = threading.Lock()

    @property
    def message(self) -> Any:
        """The message, which is built or decoded from recorded bytes on first access. Raises ValueError."""
        with self._lock:
            return self._made()

    @property
    def cdr(self) -> memoryview:
        """The message in CDR, which is encoded on first access (on any thread) and shared by all sinks."""
        with self._lock:
            if self._cdr is None:
                self._cdr = encode(self._made())
            return self._cdr

    def caught_up(self) -> Reading:
        """Return a reading with the same time stamp that combines all messages of the channel so far."""
        catch_up = self.channel.delivery.catch_up
        assert catch_up is not None
        return Reading(self.channel, None, self.time_ns, self.tick, make=lambda: catch_up(None)[0])

    def _made(self) -> Any:
        if self._message is None:
            made = self._make
            self._message = made() if made else from_bytes(bytes(self._cdr or b""), self.channel.type)
        return self._message


Sink = Callable[[Reading], object]
"""Receives a reading on the stepping thread; it must be brief and must not block."""


class Readings(Protocol):
    """A source of readings for bridges: a live simulator's feed or a recording being played."""

    def listen(self, channel: Channel, sink: Sink) -> Callable[[], None]:
        """Pass each reading of a channel to a sink from now on; return a function that unsubscribes it.

        A latched channel's latest reading is passed immediately.
        """

    def newest(self, channel: Channel) -> Reading | None:
        """Return the reading for a sink that joins a latched channel late."""

    def listen_time(self, period_s: float, sink: Callable[[int], object]) -> Callable[[], None]:
        """Report the simulated time [ns] to a sink once per simulated period; return a function that stops it."""


class Feed:
    """Shares a live simulator's channels among sinks. A channel is read only while it has at least one sink."""

    def __init__(self, live: LiveSimulator) -> None:
        self._live = live
        self._lock = threading.Lock()
        self._taps: dict[str, _Tap] = {}
        self._fresh: dict[str, Reading] = {}

    def listen(self, channel: Channel, sink: Sink) -> Callable[[], None]:
        """Pass each reading of a channel to a sink from now on; return a function that unsubscribes it.

        A latched channel's latest reading is passed immediately, on the calling thread. A channel without a rate is
        read when its first sink joins. While the simulator is paused, that applies to every channel. Raises
        NotRunningError.
        """
        with self._lock:
            tap = self._taps.get(channel.name)
            if tap is None:
                tap = self._taps[channel.name] = _Tap(self._live, channel, self._fresh)
            is_read_anew = not tap.sinks and channel.rate_hz is None
            newest = None if is_read_anew else tap.late()
            tap.sinks = (*tap.sinks, sink)
            try:
                if len(tap.sinks) == 1:
                    tap.open()
                elif newest is None and self._live.paused:
                    tap.read_once(sink)
            except RuntimeError:
                tap.sinks = tap.sinks[:-1]
                raise
        if newest is not None:
            sink(newest)
        return lambda: self._leave(tap, sink)

    def newest(self, channel: Channel) -> Reading | None:
        """Return the reading for a sink that joins a latched channel late.

        If the channel's messages build on each other, the reading combines all of them so far.
        """
        with self._lock:
            tap = self._taps.get(channel.name)
            return None if tap is None else tap.late()

    def share(self, reading: Reading) -> None:
        """Share a reading that a recorder has just taken, so that the channel is not read twice at the same tick.

        Must be called on the stepping thread.
        """
        self._fresh[reading.channel.name] = reading

    def listen_time(self, period_s: float, sink: Callable[[int], object]) -> Callable[[], None]:
        """Report the simulated time [ns] to a sink once per simulated period; return a function that stops it.

        Raises NotRunningError.
        """
        return self._live.every(period_s, lambda sim: sim.time_ns, sink).cancel

    def _leave(self, tap: _Tap, sink: Sink) -> None:
        with self._lock:
            tap.sinks = tuple(kept for kept in tap.sinks if kept is not sink)
            if not tap.sinks:
                tap.close()


class _Tap:
    """A subscription to a channel. sinks: never mutated, since the stepping thread reads it without a lock."""

    def __init__(self, live: LiveSimulator, channel: Channel, fresh: Mapping[str, Reading]) -> None:
        """fresh: readings shared by a recorder, by channel name."""
        self._fresh = fresh
        self.newest: Reading | None = None
        self.sinks: tuple[Sink, ...] = ()
        self._live = live
        self._channel = channel
        self._end: Callable[[], None] | None = None
        self._is_first = True
        self._sent: Any = None

    def open(self) -> None:
        """Start reading."""
        self._is_first = True  # while paused, a reading of this tick may predate later commands
        if self._channel.rate_hz is not None:
            period_s, leads = 1.0 / self._channel.rate_hz, self._channel.delivery.leads
            self._end = self._live.every(period_s, self._read, self._publish, leads=leads).cancel
        else:
            if self._channel.delivery.follow is not None:
                self._end = self._channel.delivery.follow(self._live.simulator, self._take)
            self.read_once(self._publish)

    def read_once(self, sink: Sink) -> None:
        """Read immediately, for a sink that would otherwise have a long wait for the next reading."""

        def take(done: Future[Reading | None]) -> None:
            error = done.exception()
            reading = done.result() if error is None else None
            if error is not None:
                logger.error("channel '%s': %s", self._channel.name, error)
            elif reading is not None:
                sink(reading)

        self._is_first = True
        self._live.read(self._read).add_done_callback(take)

    def late(self) -> Reading | None:
        """Return the reading for a sink that joins later."""
        newest = self.newest
        return newest if newest is None or self._channel.delivery.catch_up is None else newest.caught_up()

    def close(self) -> None:
        """Stop reading."""
        if self._end is not None:
            self._end()
            self._end = None

    def _take(self, message: Any) -> None:
        sim = self._live.simulator
        self._publish(Reading(self._channel, message, sim.time_ns, sim.tick))

    def _read(self, sim: Simulator) -> Reading | None:
        is_first, self._is_first = self._is_first, False
        shared = None if is_first else self._fresh.get(self._channel.name)
        if shared is not None and shared.tick != sim.tick:
            shared = None
        message = self._channel.read(sim) if shared is None else shared.message
        if message is None or (self._channel.delivery.is_sampled and message is self._sent and not is_first):
            return None
        self._sent = message
        return shared or Reading(self._channel, message, sim.time_ns, sim.tick)

    def _publish(self, reading: Reading | None) -> None:
        if reading is None:
            return
        if self._channel.delivery.latched:
            self.newest = reading
        for sink in self.sinks:
            try:
                sink(reading)
            except Exception:
                logger.exception("channel '%s': a sink failed", self._channel.name)
