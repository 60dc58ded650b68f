"""The bounded queue of every protocol: what waits for a peer, whose oldest entries give way to newer ones."""

from __future__ import annotations

import math
import threading
from collections import deque
from typing import Generic, TypeVar

T = TypeVar("T")


class Room:
    """The bytes that are kept together in several queues and elsewhere, of which there may be `most`."""

    def __init__(self, most: float = math.inf) -> None:
        self.most = most
        self.bytes = 0
        self.lock = threading.RLock()

    def has(self, size: int) -> bool:
        """Return whether there is room for so many bytes more."""
        return self.bytes + size <= self.most

    def take(self, size: int) -> None:
        """Count bytes that are kept from now on."""
        with self.lock:
            self.bytes += size

    def give(self, size: int) -> None:
        """Count bytes that are kept no longer."""
        self.take(-size)


class Waiting(Generic[T]):
    """Entries in order of arrival, at most `most` of at most most_bytes. The methods may be called on any thread.

    room: shared with other queues. An empty queue takes an entry of any size. dropped: the number of entries that gave
    way to newer ones.
    """

    def __init__(self, most: int, most_bytes: float = math.inf, room: Room | None = None) -> None:
        self.most, self._most_bytes = most, most_bytes
        self._room = Room() if room is None else room
        self._entries: deque[tuple[int, T]] = deque()
        self._is_closed = False
        self.bytes = self.dropped = 0

    def __len__(self) -> int:
        return len(self._entries)

    @property
    def oldest(self) -> T:
        """The entry that is taken next. Raises IndexError if none waits."""
        return self._entries[0][1]

    def put(self, entry: T, size: int = 0) -> None:
        """Add an entry of this many bytes; the oldest are dropped until it fits."""
        with self._room.lock:
            while not self._fits(size):
                self.drop()
            self.offer(entry, size)

    def offer(self, entry: T, size: int = 0) -> bool:
        """Add an entry, if it fits, and return whether it did. A closed queue takes any and keeps none."""
        with self._room.lock:
            fits = self._fits(size)
            if fits and not self._is_closed:
                self._entries.append((size, entry))
                self.bytes += size
                self._room.take(size)
            return fits

    def _fits(self, size: int) -> bool:
        has_room = self.bytes + size <= self._most_bytes and self._room.has(size)
        return not self._entries or (len(self._entries) < self.most and has_room)

    def take(self) -> T | None:
        """Remove and return the oldest entry, or None if none waits."""
        with self._room.lock:
            if not self._entries:
                return None
            size, entry = self._entries.popleft()
            self.bytes -= size
            self._room.give(size)
            return entry

    def taken(self, limit: float = math.inf) -> list[T]:
        """Remove and return the oldest entries, at most `limit`."""
        with self._room.lock:
            return [entry for _ in range(int(min(limit, len(self)))) if (entry := self.take()) is not None]

    def drop(self) -> None:
        """Remove the oldest entry, and count it."""
        self.take()
        self.dropped += 1

    def clear(self) -> None:
        """Remove all entries."""
        while self._entries:
            self.take()

    def close(self) -> None:
        """Remove all entries, and keep no other."""
        with self._room.lock:
            self._is_closed = True
            self.clear()
