"""Messages that are held until those on the tape before them are known, and their order in a file."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from uwsim.recording.sink import Batch, Data

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
