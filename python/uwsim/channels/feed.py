"""Feed: reads a live simulator's channels once for all who listen, and encodes each reading once."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from typing import Any, Protocol

from uwsim.channels.cdr import encode
from uwsim.channels.channel import Channel
from uwsim.channels.messages import from_bytes
from uwsim.live import LiveSimulator, Subscription
from uwsim.simulator import Simulator

logger = logging.getLogger("uwsim.channels")


class Reading:
    """One message of a channel. time_ns: simulated time at which it was read; tick: the same in steps."""

    __slots__ = ("_cdr", "_lock", "_message", "channel", "tick", "time_ns")

    def __init__(
        self, channel: Channel, message: Any, time_ns: int, tick: int, *, cdr: memoryview | None = None
    ) -> None:
        """message: None if cdr has it already."""
        self.channel = channel
        self.time_ns = time_ns
        self.tick = tick
        self._message = message
        self._cdr = cdr
        self._lock = threading.Lock()

    @property
    def message(self) -> Any:
        """The message itself: of recorded bytes, it is decoded by the first who asks. Raises ValueError."""
        with self._lock:
            if self._message is None:
                self._message = from_bytes(bytes(self._cdr or b""), self.channel.type)
            return self._message

    @property
    def cdr(self) -> memoryview:
        """The message in CDR: encoded by the first who asks, on any thread, and shared by all."""
        with self._lock:
            if self._cdr is None:
                self._cdr = encode(self._message)
            return self._cdr


Sink = Callable[[Reading], object]
"""Takes a reading on the stepping thread: it must be brief and must not block."""


class Readings(Protocol):
    """Whatever hands out readings to bridges: a live simulator's feed, or a recording that is played."""

    def listen(self, channel: Channel, sink: Sink) -> Callable[[], None]:
        """Hand each reading of a channel to a sink from now on, of a latched one the newest at once; return the end."""

    def newest(self, channel: Channel) -> Reading | None:
        """Return what somebody needs who comes later to a latched channel."""

    def tell_time(self, period_s: float, sink: Callable[[int], object]) -> Callable[[], None]:
        """Tell a sink the simulated time [ns] at each period of it; return what ends that."""


class Feed:
    """The channels of a live simulator for several sinks. A channel is read while somebody listens to it."""

    def __init__(self, live: LiveSimulator) -> None:
        self._live = live
        self._lock = threading.Lock()
        self._taps: dict[str, _Tap] = {}
        self._fresh: dict[str, Reading] = {}

    def listen(self, channel: Channel, sink: Sink) -> Callable[[], None]:
        """Hand each reading of a channel to a sink from now on; return what ends that.

        Whoever comes later to a latched channel gets the newest reading at once, on its own thread. Raises
        NotRunningError.
        """
        with self._lock:
            tap = self._taps.get(channel.name)
            if tap is None:
                tap = self._taps[channel.name] = _Tap(self._live, channel, self._fresh)
            newest = tap.late()
            tap.sinks = (*tap.sinks, sink)
            if len(tap.sinks) == 1:
                try:
                    tap.open()
                except RuntimeError:
                    tap.sinks = ()
                    raise
        if newest is not None:
            sink(newest)
        return lambda: self._leave(tap, sink)

    def newest(self, channel: Channel) -> Reading | None:
        """Return what somebody needs who comes later to a latched channel: all so far, if its messages build up."""
        with self._lock:
            tap = self._taps.get(channel.name)
            return None if tap is None else tap.late()

    def share(self, reading: Reading) -> None:
        """Hand on a reading that a recorder has just taken, not one more of that tick. On the stepping thread."""
        self._fresh[reading.channel.name] = reading

    def tell_time(self, period_s: float, sink: Callable[[int], object]) -> Callable[[], None]:
        """Tell a sink the simulated time [ns] at each period of it; return what ends that. Raises NotRunningError."""
        return self._live.every(period_s, lambda sim: sim.time_ns, sink).cancel

    def _leave(self, tap: _Tap, sink: Sink) -> None:
        with self._lock:
            tap.sinks = tuple(kept for kept in tap.sinks if kept is not sink)
            if not tap.sinks:
                tap.close()


class _Tap:
    """One channel's subscription. sinks: replaced as a whole, for the stepping thread reads them without a lock."""

    def __init__(self, live: LiveSimulator, channel: Channel, fresh: Mapping[str, Reading]) -> None:
        """fresh: what others have just read, by the channel's name."""
        self._fresh = fresh
        self.newest: Reading | None = None
        self.sinks: tuple[Sink, ...] = ()
        self._live = live
        self._channel = channel
        self._subscription: Subscription | None = None
        self._is_first = True

    def open(self) -> None:
        """Begin to read. A channel without a rate is read once."""
        self._is_first = True  # while paused, a reading of this tick may be older than the commands since
        if self._channel.rate_hz is not None:
            self._subscription = self._live.every(1.0 / self._channel.rate_hz, self._read, self._hand_on)
        elif self.newest is None:
            self._live.read(self._read).add_done_callback(self._take_once)

    def late(self) -> Reading | None:
        """Return what those need who come later."""
        newest, channel = self.newest, self._channel
        if newest is None or channel.catch_up is None:
            return newest
        return Reading(channel, channel.catch_up(None)[0], newest.time_ns, newest.tick)

    def close(self) -> None:
        """Read no more."""
        if self._subscription is not None:
            self._subscription.cancel()
            self._subscription = None

    def _read(self, sim: Simulator) -> Reading | None:
        shared = None if self._is_first else self._fresh.get(self._channel.name)
        self._is_first = False
        if shared is not None and shared.tick == sim.tick:
            return shared
        message = self._channel.read(sim)
        return None if message is None else Reading(self._channel, message, sim.time_ns, sim.tick)

    def _take_once(self, done: Future[Reading | None]) -> None:
        error = done.exception()
        if error is None:
            self._hand_on(done.result())
        else:
            logger.error("channel '%s': %s", self._channel.name, error)

    def _hand_on(self, reading: Reading | None) -> None:
        if reading is None:
            return
        if self._channel.latched:
            self.newest = reading
        for sink in self.sinks:
            try:
                sink(reading)
            except Exception:
                logger.exception("channel '%s': a sink failed", self._channel.name)
