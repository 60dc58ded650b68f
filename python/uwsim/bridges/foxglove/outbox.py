"""A client's queue of outgoing frames, limited in bytes both per client and in total.

There are two queues. One contains frames that must arrive: the topic list, answers, and scenes, which build on each
other. A client with too many of these is disconnected. The other contains topic messages, of which the oldest are
dropped in favour of newer ones.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable

from uwsim.bridges.doors.conversation import Frame
from uwsim.bridges.foxglove import protocol

REPLIES = 1000
REPLIES_BYTES = 64 << 20  # the scene for a large map takes about 10 MB
MESSAGES = 64
MESSAGES_BYTES = 16 << 20
ALL_BYTES = 256 << 20
OVERHEAD = 200  # bytes that a queue entry takes in addition to its content

Message = tuple[int, int, bytes]
"""The subscription, the time [ns] and the content, which is shared by all clients that receive it."""


class Room:
    """The total size of all client queues."""

    def __init__(self, limit: int = ALL_BYTES) -> None:
        self.lock = threading.Lock()
        self.limit = limit
        self.taken = 0


class _Queue:
    """Frames in order of arrival. Callers must hold the lock of the room."""

    def __init__(self, room: Room, count: int, size: int) -> None:
        self._room = room
        self._count, self._size = count, size
        self._entries: deque[tuple[int, Frame | Message]] = deque()
        self.bytes = 0

    def __len__(self) -> int:
        return len(self._entries)

    def has_room(self, size: int) -> bool:
        """Return whether an entry fits. An empty queue accepts an entry of any size."""
        fits = self.bytes + size <= self._size and self._room.taken + size <= self._room.limit
        return not self._entries or (len(self._entries) < self._count and fits)

    def put(self, size: int, entry: Frame | Message) -> None:
        self._entries.append((size, entry))
        self.bytes += size
        self._room.taken += size

    def take(self) -> Frame | Message:
        size, entry = self._entries.popleft()
        self.bytes -= size
        self._room.taken -= size
        return entry

    def clear(self) -> None:
        self._room.taken -= self.bytes
        self._entries.clear()
        self.bytes = 0


class Outbox:
    """A client's queues. The methods may be called on any thread and never block.

    wake: called when there is a frame to send. give_up: called with the reason when too much is queued. dropped: number
    of messages dropped in favour of newer ones.
    """

    def __init__(self, room: Room, wake: Callable[[], None], give_up: Callable[[str], None]) -> None:
        self._room, self._wake, self._give_up = room, wake, give_up
        self._replies = _Queue(room, REPLIES, REPLIES_BYTES)
        self._messages = _Queue(room, MESSAGES, MESSAGES_BYTES)
        self._time_ns: int | None = None
        self._is_closed = False
        self.dropped = 0

    @property
    def bytes(self) -> int:
        """The size of both queues [bytes]."""
        return self._replies.bytes + self._messages.bytes

    def reply(self, frame: Frame) -> None:
        """Queue a frame that must arrive."""
        self._must(len(frame) + OVERHEAD, frame)

    def put(self, message: Message, *, builds_up: bool = False) -> None:
        """Queue a topic message. builds_up: whether later messages are useless without it."""
        size = len(message[2]) + OVERHEAD
        if builds_up:
            self._must(size, message)
            return
        with self._room.lock:
            if self._is_closed:
                return
            while not self._messages.has_room(size):
                self._messages.take()
                self.dropped += 1
            self._messages.put(size, message)
        self._wake()

    def send_time(self, time_ns: int) -> None:
        """Queue the simulated time, replacing any time already queued."""
        self._time_ns = time_ns
        self._wake()

    def take(self) -> Frame | None:
        """Return the next frame, or None."""
        with self._room.lock:
            if self._replies:
                found = self._replies.take()
            elif self._time_ns is not None:
                found, self._time_ns = protocol.time(self._time_ns), None
            elif self._messages:
                found = self._messages.take()
            else:
                return None
        return protocol.message(*found) if isinstance(found, tuple) else found

    def close(self) -> None:
        """Drop all queued frames and ignore further ones."""
        with self._room.lock:
            self._is_closed = True
            self._replies.clear()
            self._messages.clear()

    def _must(self, size: int, entry: Frame | Message) -> None:
        with self._room.lock:
            if self._is_closed:
                return
            has_room = self._replies.has_room(size)
            if has_room:
                self._replies.put(size, entry)
        if has_room:
            self._wake()
            return
        reason = f"it reads too slowly: {len(self._replies)} answers and scenes of {self._replies.bytes} bytes wait"
        self.close()
        self._give_up(reason)
