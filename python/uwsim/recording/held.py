"""Messages that are held until those on the tape before them are known, and their order in a file."""

from __future__ import annotations

from itertools import repeat

import numpy as np
from numpy.typing import NDArray

from uwsim.recording.sink import Data

LAST = 1 << 30
"""The rank of what follows the readings of a tick: commands, and messages from elsewhere."""


class Held:
    """Messages in order of time and, at the same time, of rank: that of a reading is its channel's place."""

    def __init__(self) -> None:
        self._clear()

    def _clear(self) -> None:
        self._topics: list[str] = []
        self._data: list[Data] = []
        self._times_ns: list[int] = []
        self._ranks: list[int] = []

    def add(self, topic: str, time_ns: int, data: Data, rank: int = LAST) -> None:
        """Add a message, after those of the same time and rank."""
        self._topics.append(topic)
        self._data.append(data)
        self._times_ns.append(time_ns)
        self._ranks.append(rank)

    def add_all(self, topic: str, times_ns: NDArray[np.uint64], data: list[bytes], rank: int) -> None:
        """Add messages of one topic at times (n,)."""
        self._topics += repeat(topic, len(data))
        self._data += data
        self._times_ns += times_ns.tolist()
        self._ranks += repeat(rank, len(data))

    def taken(self) -> list[tuple[str, int, Data]]:
        """Return all messages in order, topic, time and data of each, and hold none."""
        order = np.lexsort((np.array(self._ranks, np.int64), np.array(self._times_ns, np.int64))).tolist()
        found = [(self._topics[k], self._times_ns[k], self._data[k]) for k in order]
        self._clear()
        return found
