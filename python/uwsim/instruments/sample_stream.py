"""Streams that deliver each of a sensor's samples once, as it arrives."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any
from weakref import ref

import numpy as np
from numpy.typing import NDArray

from uwsim.base.agenda import Agenda, Rank

KEPT = 1_000_000
"""The most samples that a stream keeps until they are taken: 83 minutes at 200 Hz."""
JOINED, EVERY_STEPS = 1000, 2000
"""Pieces that are joined into one, and the steps between which streams receive what has not been asked for."""
Take = Callable[[], tuple[Any, Any, Any, Any]]


@dataclass(eq=False, slots=True)  # frozen, one would take three times as long to make
class Samples:
    """Samples in order of arrival, without dropped samples.

    stamps_ns, arrivals_ns: (n,) uint64, times of measurement and arrival. readings: (n, width) float64, the columns of
    the kind's fields (_core.sensor_kind(kind).fields) side by side. valid: (n,), whether there was a measurement.
    """

    stamps_ns: NDArray[np.uint64]
    arrivals_ns: NDArray[np.uint64]
    readings: NDArray[np.float64]
    valid: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.stamps_ns)

    def since(self, from_ns: int) -> Samples:
        """Return the samples measured at from_ns or later."""
        if not len(self) or self.stamps_ns[0] >= from_ns:  # stamps increase
            return self
        first = int(np.searchsorted(self.stamps_ns, np.uint64(from_ns)))
        return Samples(*(part[first:] for part in self.parts))

    @property
    def parts(self) -> tuple[NDArray[Any], ...]:
        """The four arrays."""
        return self.stamps_ns, self.arrivals_ns, self.readings, self.valid

    @staticmethod
    def joined(pieces: Sequence[Samples]) -> Samples:
        """Return the concatenation of several pieces."""
        if len(pieces) == 1:
            return pieces[0]
        columns = zip(*(piece.parts for piece in pieces), strict=True)
        return Samples(*(np.concatenate(column) for column in columns))


class SampleStream:
    """Delivers the samples that a sensor measures from a given time onwards; see Sensor.stream.

    dropped: how many samples, the oldest, were dropped since they were not taken and KEPT others followed.
    """

    def __init__(self, source: SampleSource, from_ns: int) -> None:
        self._source = source
        self._from_ns = from_ns
        self._pieces: list[Samples] = []
        self._count = self._large = 0  # of samples, and of joined pieces, which come first
        self.dropped = 0
        self.is_fed = True

    def take(self) -> Samples:
        """Return the samples that have arrived since the previous call."""
        if not self.is_fed:
            raise ValueError("the stream has ended, as its simulator was reset or restored: ask the sensor for another")
        newest = self._source.hand_out()
        if not self._pieces:
            return newest  # which is empty
        pieces, self._pieces, self._count, self._large = self._pieces, [], 0, 0
        return Samples.joined(pieces)

    def receive(self, samples: Samples) -> None:
        """Store samples for the next `take`."""
        new = samples.since(self._from_ns)
        self._pieces.append(new)
        self._count += len(new)
        if len(self._pieces) - self._large >= JOINED:
            self._pieces[self._large :] = [Samples.joined(self._pieces[self._large :])]
            self._large += 1
        while self._count > KEPT:
            self._drop(self._count - KEPT)

    def _drop(self, most: int) -> None:
        """Drop the oldest samples, at most so many: those of one piece."""
        oldest = self._pieces[0]
        if (count := min(len(oldest), most)) < len(oldest):
            self._pieces[0] = Samples(*(part[count:] for part in oldest.parts))
        else:
            del self._pieces[0]
            self._large = max(self._large - 1, 0)
        self._count -= count
        self.dropped += count

    def close(self) -> None:
        """Stop the stream."""
        self._source.leave(self)

    __del__ = close


class SampleSource:
    """Distributes a sensor's samples to all its streams, which it does not keep alive.

    take: returns the sensor's new samples. watch: called with from_ns to start collecting samples from then on, or with
    None to stop.
    """

    def __init__(self, take: Take, watch: Callable[[int | None], None]) -> None:
        self._take = take
        self._watch = watch
        self._streams: list[ref[SampleStream]] = []
        self._newest: Samples | None = None  # those that were handed out last; None before the first
        self._watched_ns = 0
        self._lock = threading.Lock()
        self.opened: Callable[[], None] = lambda: None  # called with each new stream
        self.closed: Callable[[], None] = lambda: None  # called after `close`

    @property
    def is_watched(self) -> bool:
        """True while there are streams."""
        return bool(self._streams)

    def stream(self, from_ns: int) -> SampleStream:
        """Return a new stream. It gets the present sample, whether or not another has taken it."""
        self.opened()
        stream = SampleStream(self, from_ns)
        if self._streams:
            self.hand_out()
        if not self._streams or (self._newest is None and from_ns < self._watched_ns):
            self._watched_ns = from_ns
            self._watch(from_ns)
        elif self._newest is not None:
            stream.receive(Samples(*(part[-1:] for part in self._newest.parts)))
        self._streams.append(ref(stream))
        return stream

    def leave(self, stream: SampleStream) -> None:
        """Remove a stream; once the last one is gone, samples are no longer collected."""
        if stream.is_fed:
            stream.is_fed = False
            self._streams = [each for each in self._streams if (fed := each()) is not None and fed is not stream]
            if not self._streams:
                self._end()

    def close(self) -> None:
        """End all streams because the simulator is going back in time."""
        for each in self._streams:
            if (stream := each()) is not None:
                stream.is_fed = False
        self._streams = []
        self._end()
        self.closed()

    def _end(self) -> None:
        self._newest, self._watched_ns = None, 0
        self._watch(None)

    def settle(self) -> None:
        """Deliver everything that has arrived so far, before the sensor's errors or power state change."""
        if self._streams:
            self.hand_out()

    def hand_out(self) -> Samples:
        """Deliver everything that has arrived to all streams, and return it."""
        with self._lock:  # the thread that steps does so as well
            samples = Samples(*self._take())
            if len(samples.stamps_ns):  # a filter takes from each sensor at each step of a controller, mostly in vain
                self._newest = samples
                for each in self._streams:
                    if (stream := each()) is not None:
                        stream.receive(samples)
        return samples


class Deliveries:
    """Delivers the samples of a simulator's sensors from time to time, so that streams that are not taken are bounded.

    due_tick: when it does so next, at multiples of EVERY_STEPS, whenever a stream was opened.
    """

    def __init__(self, agenda: Agenda, sources: Iterable[SampleSource]) -> None:
        self._agenda, self._sources = agenda, tuple(sources)
        self.due_tick = 0
        for source in self._sources:
            source.opened = self._begin
            source.closed = self._end

    def _begin(self) -> None:
        if self not in self._agenda:
            self._schedule(self._agenda.tick)
            self._agenda.add(self, Rank.OBSERVER, self._deliver, jump=self._schedule)

    def _schedule(self, tick: int) -> None:
        self.due_tick = (tick // EVERY_STEPS + 1) * EVERY_STEPS

    def _deliver(self, tick: int) -> None:
        self._schedule(tick)
        for source in self._sources:
            source.settle()
        self._end()

    def _end(self) -> None:
        if self in self._agenda and not any(source.is_watched for source in self._sources):
            self._agenda.remove(self)
