"""Streams that deliver each of a sensor's samples once, as it arrives."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any
from weakref import ref

import numpy as np
from numpy.typing import NDArray

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
    """Delivers the samples that a sensor measures from a given time onwards; see Sensor.stream."""

    def __init__(self, source: SampleSource, from_ns: int) -> None:
        self._source = source
        self._from_ns = from_ns
        self._pieces: list[Samples] = []
        self.is_fed = True

    def take(self) -> Samples:
        """Return the samples that have arrived since the previous call."""
        if not self.is_fed:
            raise ValueError("the stream has ended, as its simulator was reset or restored: ask the sensor for another")
        newest = self._source.hand_out()
        if not self._pieces:
            return newest  # which is empty
        pieces, self._pieces = self._pieces, []
        return Samples.joined(pieces)

    def receive(self, samples: Samples) -> None:
        """Store samples for the next `take`."""
        self._pieces.append(samples.since(self._from_ns))

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

    def stream(self, from_ns: int) -> SampleStream:
        """Return a new stream. It gets the present sample, whether or not another has taken it."""
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

    def _end(self) -> None:
        self._newest, self._watched_ns = None, 0
        self._watch(None)

    def settle(self) -> None:
        """Deliver everything that has arrived so far, before the sensor's errors or power state change."""
        if self._streams:
            self.hand_out()

    def hand_out(self) -> Samples:
        """Deliver everything that has arrived to all streams, and return it."""
        samples = Samples(*self._take())
        if len(samples.stamps_ns):  # a filter takes from each sensor at each step of a controller, mostly in vain
            self._newest = samples
            for each in self._streams:
                if (stream := each()) is not None:
                    stream.receive(samples)
        return samples
