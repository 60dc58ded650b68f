"""A client's queue of outgoing frames, limited in bytes both per client and in total.

There are two queues. One contains frames that must arrive: the topic list, answers, and scenes, which build on each
other. A client with too many of these is disconnected. The other contains topic messages, of which the oldest are
dropped in favour of newer ones.
"""

from __future__ import annotations

from collections.abc import Callable

from uwsim.bridges.doors.conversation import Frame
from uwsim.bridges.doors.waiting import Room, Waiting
from uwsim.bridges.foxglove import protocol

REPLIES = 1000
REPLIES_BYTES = 64 << 20  # the scene for a large map takes about 10 MB
MESSAGES = 64
MESSAGES_BYTES = 16 << 20
ALL_BYTES = 256 << 20
OVERHEAD = 200  # bytes that a queue entry takes in addition to its content

Message = tuple[int, int, bytes]
"""The subscription, the time [ns] and the content, which is shared by all clients that receive it."""


class Outbox:
    """A client's queues. The methods may be called on any thread and never block.

    room: shared by all clients. wake: called when there is a frame to send. give_up: called with the reason when too
    much is queued.
    """

    def __init__(self, room: Room, wake: Callable[[], None], give_up: Callable[[str], None]) -> None:
        self._wake, self._give_up = wake, give_up
        self._replies = Waiting[Frame | Message](REPLIES, REPLIES_BYTES, room)
        self._messages = Waiting[Message](MESSAGES, MESSAGES_BYTES, room)
        self._time_ns: int | None = None

    @property
    def bytes(self) -> int:
        """The size of both queues [bytes]."""
        return self._replies.bytes + self._messages.bytes

    @property
    def dropped(self) -> int:
        """The number of messages that gave way to newer ones."""
        return self._messages.dropped

    def reply(self, frame: Frame) -> None:
        """Queue a frame that must arrive."""
        self._must(len(frame) + OVERHEAD, frame)

    def put(self, message: Message, *, builds_up: bool = False) -> None:
        """Queue a topic message. builds_up: whether later messages are useless without it."""
        size = len(message[2]) + OVERHEAD
        if builds_up:
            self._must(size, message)
            return
        self._messages.put(message, size)
        self._wake()

    def send_time(self, time_ns: int) -> None:
        """Queue the simulated time, replacing any time already queued."""
        self._time_ns = time_ns
        self._wake()

    def take(self) -> Frame | None:
        """Return the next frame, or None."""
        found = self._replies.take()
        if found is None and self._time_ns is not None:
            found, self._time_ns = protocol.time(self._time_ns), None
        if found is None:
            found = self._messages.take()
        return protocol.message(*found) if isinstance(found, tuple) else found

    def close(self) -> None:
        """Drop all queued frames and ignore further ones."""
        self._replies.close()
        self._messages.close()

    def _must(self, size: int, entry: Frame | Message) -> None:
        if self._replies.offer(entry, size):
            self._wake()
            return
        reason = f"it reads too slowly: {len(self._replies)} answers and scenes of {self._replies.bytes} bytes wait"
        self.close()
        self._give_up(reason)
