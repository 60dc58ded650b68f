"""The destination of a recording, for all formats, and the bounded path to it from the simulator's thread."""

from __future__ import annotations

import logging
import threading
import time
from collections import Counter, deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import groupby
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from uwsim.channels import Channel
from uwsim.channels.delivery.feed import Reading

Data = bytes | memoryview
Item = tuple[str, int, int, Data]
"""A message: topic, time [ns], sequence number, data."""


class Batch(NamedTuple):
    """Messages in order.

    which: (n,), the place of each one's topic among `topics`. times_ns, sequences, data: n each.
    """

    topics: Sequence[str]
    which: NDArray[np.intp]
    times_ns: NDArray[np.int64]
    sequences: NDArray[np.int64]
    data: Sequence[Data]

    @classmethod
    def of(cls, items: Sequence[Item]) -> Batch:
        """Return the batch of some messages, at least one."""
        topics, times_ns, sequences, data = zip(*items, strict=True)
        places = {topic: place for place, topic in enumerate(dict.fromkeys(topics))}
        which = np.array([places[topic] for topic in topics])
        return cls(list(places), which, np.array(times_ns), np.array(sequences), data)


class Sink(Protocol):
    """A file that accepts messages. All methods except `encode` are called by one thread at a time."""

    def encode(self, reading: Reading) -> Data:
        """Return a message in the format's serialization."""

    def add_channel(self, channel: Channel) -> None:
        """Register a channel before its first message."""

    def write(self, messages: Batch) -> None:
        """Append messages, at least one, at their simulated times. Raises OSError."""

    def flush(self) -> None:
        """Pass all written data to the operating system, so that they are safe if the process is killed.

        Raises OSError.
        """

    def close(self, end: Mapping[str, str]) -> None:
        """Write the end of the file and close it. Raises OSError."""

    def abandon(self) -> None:
        """Close after a write error, keeping everything readable."""


LAST = 1 << 30
"""The rank of what follows the readings of a tick: commands, and messages from elsewhere."""


class Held:
    """Messages in order of time and, at the same time, of rank: that of a reading is its channel's place."""

    def __init__(self) -> None:
        self._topics: dict[str, int] = {}
        self._clear()

    def _clear(self) -> None:
        self._data: list[Data] = []
        self._keys: list[NDArray[np.int64]] = []  # of the data in order: rank, time and topic, (3, n) each
        self._single: list[tuple[int, int, int]] = []  # the same of the last data, one by one

    def add(self, topic: str, time_ns: int, data: Data, rank: int = LAST) -> None:
        """Add a message, after those of the same time and rank."""
        self._data.append(data)
        self._single.append((rank, time_ns, self._place(topic)))

    def add_all(self, topic: str, times_ns: NDArray[np.uint64], data: list[bytes], rank: int) -> None:
        """Add messages of one topic at times (n,)."""
        self._join_single()
        self._data += data
        keys = np.empty((3, len(data)), np.int64)
        keys[0], keys[1], keys[2] = rank, times_ns, self._place(topic)
        self._keys.append(keys)

    def _place(self, topic: str) -> int:
        return self._topics.setdefault(topic, len(self._topics))

    def _join_single(self) -> None:
        if self._single:
            self._keys.append(np.array(self._single, np.int64).T)
            self._single = []

    def taken(self, numbers: Counter[str]) -> Batch | None:
        """Return all messages in order, and hold none; None if there are none. numbers: each topic's next."""
        self._join_single()
        if not self._data:
            return None
        ranks, times_ns, which = np.concatenate(self._keys, axis=1)
        order = np.lexsort((ranks, times_ns))
        data = [self._data[k] for k in order.tolist()]
        self._clear()
        which = which[order]
        topics = list(self._topics)
        return Batch(topics, which, times_ns[order], _numbered(topics, which, numbers), data)


def _numbered(topics: Sequence[str], which: NDArray[np.int64], numbers: Counter[str]) -> NDArray[np.int64]:
    """Return the number of each message (n,) of a topic, and count on."""
    counts = np.bincount(which, minlength=len(topics))
    firsts = np.array([numbers[topic] for topic in topics]) - np.cumsum(counts) + counts
    found = np.empty(len(which), np.int64)
    found[np.argsort(which, kind="stable")] = np.arange(len(which)) + np.repeat(firsts, counts)
    numbers.update(dict(zip(topics, counts.tolist(), strict=True)))
    return found


WAITING_BYTES = 64 << 20
"""Maximum number of queued bytes; beyond it, messages are dropped or, at maximum speed, steps wait."""
MESSAGE_BYTES = 200  # size of a queue entry, in addition to its data
FLUSH_S = 1.0
"""Wall time after which written data are passed to the operating system; a kill loses at most this much."""
GATHER_S = 0.1

logger = logging.getLogger("uwsim.recording")


class WritingQueue:
    """Messages waiting for a thread that writes them to a sink.

    error: the reason why nothing more can be written, such as a full disk. The simulation continues regardless.
    """

    def __init__(self, sink: Sink, limit_bytes: int = WAITING_BYTES) -> None:
        self.error: OSError | None = None
        self._sink = sink
        self._limit_bytes = limit_bytes
        self._items: deque[Item | Batch] = deque()
        self._bytes = 0
        self._changed = threading.Condition()
        self._ends = False
        self._thread = threading.Thread(target=self._write_all, name="uwsim-recording", daemon=True)
        self._thread.start()

    def put(self, item: Item, *, waits: bool, needed: bool = False) -> bool:
        """Queue a message; return whether it will be written.

        waits: whether to wait for space. needed: whether to queue it even if there is no space.
        """
        size = len(item[3]) + MESSAGE_BYTES
        with self._changed:
            while self._bytes + size > self._limit_bytes and self._items and not needed:
                if not waits or self.error is not None:
                    return False
                self._changed.wait()
            if self.error is not None:
                return False
            self._items.append(item)
            self._bytes += size
            if self._bytes > self._limit_bytes // 2:
                self._changed.notify_all()
        return True

    def put_all(self, messages: Batch) -> None:
        """Queue messages; wait while the queue is full. After an error, they are left out."""
        size = sum(map(len, messages.data)) + MESSAGE_BYTES * len(messages.data)
        with self._changed:
            while self._bytes > self._limit_bytes // 2 and self.error is None:
                self._changed.wait()
            if self.error is None:
                self._items.append(messages)
                self._bytes += size
                self._changed.notify_all()

    def close(self, end: Mapping[str, str]) -> None:
        """Write all queued messages and close the sink. Raises OSError if that fails or an earlier write failed."""
        with self._changed:
            self._ends = True
            self._changed.notify_all()
        self._thread.join()
        if self.error is not None:
            self._sink.abandon()
            raise self.error
        self._sink.close(end)

    def _write_all(self) -> None:
        flush_at_s = time.monotonic() + FLUSH_S
        while True:
            with self._changed:
                if not self._ends and self._bytes <= self._limit_bytes // 2:
                    self._changed.wait(GATHER_S)  # waking the thread for each message would slow down the steps
                items, self._items = self._items, deque[Item | Batch]()
                self._bytes = 0
                self._changed.notify_all()
                ends = self._ends and not items
            try:
                for batch in _batches(items):
                    self._sink.write(batch)
                if ends or time.monotonic() >= flush_at_s:
                    self._sink.flush()
                    flush_at_s = time.monotonic() + FLUSH_S
            except OSError as error:
                logger.error("the recording ends: %s", error.strerror or error)
                with self._changed:
                    self.error = error
                    self._items.clear()
                    self._changed.notify_all()
                return
            if ends:
                return


def _batches(items: Iterable[Item | Batch]) -> Iterator[Batch]:
    """Return batches in the same order, in which neighbouring messages are together."""
    for kind, group in groupby(items, key=type):
        together: list[Any] = list(group)
        yield from together if kind is Batch else [Batch.of(together)]
