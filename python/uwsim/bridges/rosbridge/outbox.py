"""The messages queued for one client, in bounded memory: answers first, then each subscription's messages.

A client that does not read loses the oldest messages of its subscriptions, without affecting other clients. If too many
answers wait, it is disconnected. Across all unthrottled topics, messages are sent in order of arrival.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from uwsim.bridges.doors.conversation import Frame
from uwsim.bridges.doors.waiting import Room, Waiting
from uwsim.bridges.rosbridge.encoding import Compression, Sample
from uwsim.bridges.rosbridge.fragments import split
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.channels.ros.messages import Ros

DEFAULT_QUEUE = 10
LARGE_QUEUE = 8


class Parcel(NamedTuple):
    """A message to send, with the subscriber's encoding. `encode` may take long and may run on any thread."""

    sample: Sample
    topic: str
    ros: Ros
    compression: Compression
    fragment_size: int | None

    def encode(self) -> Frame:
        """Return the encoded frame."""
        return self.sample.frame(self.topic, self.ros, self.compression)


class Mailbox:
    """One subscription's queue. throttle_s: minimum wall time between messages. length: 0 for the default.

    As in rosbridge, a throttled subscription without a queue loses messages that arrive too early. With a queue, it
    receives them later. room: of the client. credit: maximum number of unacknowledged messages, or None. fragment_size:
    maximum number of characters in a frame of JSON, or None.
    """

    def __init__(
        self,
        topic: str,
        ros: Ros,
        room: Room,
        compression: Compression,
        *,
        throttle_s: float,
        length: int,
        large: bool,
        credit: int | None = None,
        fragment_size: int | None = None,
    ) -> None:
        self.topic = topic
        self._fragment_size = fragment_size
        self.ros: Ros = ros
        self.compression: Compression = compression
        self.throttle_s = throttle_s
        self.drops_early = throttle_s > 0 and length == 0
        default = 1 if large or self.drops_early else DEFAULT_QUEUE
        longest = min(length, LARGE_QUEUE) if large else length
        self.samples = Waiting[tuple[int, Sample]](longest or default, room=room)
        self.next_s = float("-inf")
        self._credit = credit
        self._unacknowledged = 0
        self._turn = math.inf  # of the oldest message that was dropped since the last one was sent
        self._cursor: Any = None  # for messages that build on each other

    @property
    def turn(self) -> float:
        """The order in which it is served: newer messages inherit that of those dropped, lest a fast topic starve."""
        return min(self._turn, self.samples.oldest[0])

    @property
    def is_blocked(self) -> bool:
        """Whether the client must acknowledge messages before more are sent."""
        return self._credit is not None and self._unacknowledged >= self._credit

    def acknowledge(self, count: int) -> None:
        """Restore credit for acknowledged messages."""
        self._unacknowledged = max(0, self._unacknowledged - count)

    def put(self, order: int, sample: Sample, now_s: float) -> None:
        """Queue a sample, dropping the oldest samples if there are too many or they take too many bytes."""
        if self.drops_early and now_s < self.next_s and not sample.builds_up:
            return
        if sample.builds_up:
            self.samples.clear()  # the new sample contains their content
        oldest, dropped = self.turn if self.samples else math.inf, self.samples.dropped
        self.samples.put((order, sample), sample.size)
        if self.samples.dropped > dropped:
            self._turn = oldest

    def drop(self) -> None:
        """Drop the oldest sample."""
        self._turn = self.turn
        self.samples.drop()

    def take(self, now_s: float) -> Parcel:
        """Remove the oldest sample from the queue and return it."""
        self.next_s, self._turn = now_s + self.throttle_s, math.inf
        self._unacknowledged += 1
        _, oldest = self.samples.oldest
        self.samples.take()
        sample, self._cursor = oldest.after(self._cursor)
        return Parcel(sample, self.topic, self.ros, self.compression, self._fragment_size)


class Outbox:
    """A client's queues. wake: called when there is something to send. give_up: disconnects the client for a reason.

    room: the bytes of the queues. kept: those of all else that is kept for the client.
    """

    def __init__(
        self,
        limits: Limits,
        clock: Callable[[], float] = time.monotonic,
        wake: Callable[[], None] = lambda: None,
        give_up: Callable[[str], None] = lambda reason: None,
    ) -> None:
        self._limits, self._clock, self._wake, self._give_up = limits, clock, wake, give_up
        self.room, self.kept = Room(limits.room(1)), Room(limits.room(1))
        self._replies = Waiting[tuple[Frame, int | None]](limits.replies, room=self.room)
        self._rest: Iterator[str] = iter(())  # the remaining fragments of the current frame
        self._fragmented = 0
        self._mailboxes: dict[Any, Mailbox] = {}
        self._order = 0

    def reply(self, frame: Frame, fragment_size: int | None = None) -> None:
        """Queue an answer, to be sent in fragments if it is JSON longer than fragment_size.

        A client with too many unread answers is disconnected.
        """
        size = sys.getsizeof(frame)
        self._make_room(size)
        if self._replies.offer((frame, fragment_size), size):
            self._wake()
        else:
            waiting = f"{len(self._replies)} answers of {self._replies.bytes / 1e6:.1f} MB are waiting to be read"
            self._give_up(f"{waiting}: you read too slowly")

    def share(self, clients: int) -> None:
        """Reduce the room to that of one of so many clients. A client that cannot give up enough is disconnected."""
        self.room.most = self.kept.most = self._limits.room(clients)
        self._make_room()
        if not self.kept.has(0) or (not self.room.has(0) and len(self._replies) > 1):
            size = self.kept.bytes + self._replies.bytes
            self._give_up(f"{size / 1e6:.1f} MB are kept for you, too much for one of {clients} clients")

    def _make_room(self, size: int = 0) -> None:
        """Drop the oldest messages until so many bytes more may be kept; without any, one message may wait alone."""
        while not self.room.has(size) and (waiting := [box for box in self._mailboxes.values() if box.samples]):
            if size == 0 and len(self._replies) + sum(len(box.samples) for box in waiting) == 1:
                return
            min(waiting, key=_turn).drop()

    def open(self, key: Any, mailbox: Mailbox) -> None:
        """Add a subscription's queue, or replace it."""
        self.close(key)
        self._mailboxes[key] = mailbox

    def close(self, key: Any) -> None:
        """Remove a subscription's queue and its contents."""
        mailbox = self._mailboxes.pop(key, None)
        if mailbox is not None:
            mailbox.samples.close()

    def shut(self) -> None:
        """Drop everything and ignore further messages."""
        for key in list(self._mailboxes):
            self.close(key)
        self._replies.close()
        self._rest = iter(())
        self._give_up = _stay  # so that the outbox does not keep its session in memory

    def acknowledge(self, key: Any, count: int) -> None:
        """Record that the client has processed messages from a subscription."""
        mailbox = self._mailboxes.get(key)
        if mailbox is not None:
            mailbox.acknowledge(count)
            self._wake()

    def put(self, key: Any, sample: Sample) -> None:
        """Queue a sample for a subscription."""
        mailbox = self._mailboxes.get(key)
        if mailbox is not None:
            self._order += 1
            mailbox.put(self._order, sample, self._clock())
            self._make_room()
            self._wake()

    @property
    def lost(self) -> int:
        """The number of messages of current subscriptions that were dropped in favour of newer ones."""
        return sum(mailbox.samples.dropped for mailbox in self._mailboxes.values())

    def pick(self) -> tuple[Frame | Parcel | None, float | None]:
        """Return the next frame or parcel to send.

        If there is none, return None and the seconds until a throttled message is due (None without one). The frame of
        a parcel must be passed to `begun`.
        """
        fragment = next(self._rest, None)
        if fragment is not None:
            return fragment, None
        answer = self._replies.take()
        if answer is not None:
            return self.begun(*answer), None
        now_s = self._clock()
        waiting = [mailbox for mailbox in self._mailboxes.values() if mailbox.samples and not mailbox.is_blocked]
        due = [mailbox for mailbox in waiting if mailbox.next_s <= now_s]
        if due:
            return min(due, key=_turn).take(now_s), None
        return None, min((mailbox.next_s - now_s for mailbox in waiting), default=None)

    def begun(self, frame: Frame, fragment_size: int | None) -> Frame:
        """Return a frame or, for text longer than fragment_size, its first fragment. `pick` returns the rest."""
        if fragment_size is None or isinstance(frame, bytes) or len(frame) <= fragment_size:
            return frame
        self._fragmented += 1
        self._rest = split(frame, fragment_size, str(self._fragmented), self._limits.fragments)
        return next(self._rest)

    def take(self) -> tuple[Frame | None, float | None]:
        """Do the same as `pick`, but return the encoded frame."""
        found, delay_s = self.pick()
        return self.begun(found.encode(), found.fragment_size) if isinstance(found, Parcel) else found, delay_s


def _stay(reason: str) -> None:
    """Do nothing, because the client is already leaving."""


def _turn(mailbox: Mailbox) -> float:
    return mailbox.turn
