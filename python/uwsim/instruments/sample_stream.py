"""Streams that deliver each of a sensor's samples once, as it arrives."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any
from weakref import WeakSet

import numpy as np
from numpy.typing import NDArray

Take = Callable[[], tuple[Any, Any, Any, Any]]


@dataclass(frozen=True, eq=False)
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
        new = self.stamps_ns >= from_ns
        return self if new.all() else Samples(*(part[new] for part in self.parts))

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

    def take(self) -> Samples:
        """Return the samples that have arrived since the previous call."""
        if not self._source.feeds(self):
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
    """Distributes a sensor's samples to all its streams.

    take: returns the sensor's new samples. watch: called with from_ns to start collecting samples, or with None to
    stop.
    """

    def __init__(self, take: Take, watch: Callable[[int | None], None]) -> None:
        self._take = take
        self._watch = watch
        self._streams: WeakSet[SampleStream] = WeakSet()

    def stream(self, from_ns: int) -> SampleStream:
        """Return a new stream."""
        if self._streams:
            self.hand_out()
        else:
            self._watch(from_ns)
        stream = SampleStream(self, from_ns)
        self._streams.add(stream)
        return stream

    def feeds(self, stream: SampleStream) -> bool:
        """Return whether a stream is still active."""
        return stream in self._streams

    def leave(self, stream: SampleStream) -> None:
        """Remove a stream; once the last one is gone, samples are no longer collected."""
        if self.feeds(stream):
            self._streams.discard(stream)
            if not self._streams:
                self._watch(None)

    def close(self) -> None:
        """End all streams because the simulator is going back in time."""
        self._streams.clear()
        self._watch(None)

    def settle(self) -> None:
        """Deliver everything that has arrived so far, before the sensor's errors or power state change."""
        if self._streams:
            self.hand_out()

    def hand_out(self) -> Samples:
        """Deliver everything that has arrived to all streams, and return it."""
        samples = Samples(*self._take())
        if len(samples):  # a filter takes from each sensor at each step of a controller, mostly in vain
            for stream in self._streams:
                stream.receive(samples)
        return samples
