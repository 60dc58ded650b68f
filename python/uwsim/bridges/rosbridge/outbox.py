"""The messages queued for one client, in bounded memory: answers first, then each subscription's messages.

A client that does not read loses the oldest messages of its subscriptions, without affecting other clients. If too many
bytes are queued nevertheless, it is disconnected. Across all unthrottled topics, messages are sent in order of arrival.
"""

from __future__ import annotations

import math
import sys
from collections import deque
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from uwsim.bridges.doors.conversation import Frame
from uwsim.bridges.rosbridge.encoding import Compression, Sample
from uwsim.bridges.rosbridge.fragments import split
from uwsim.bridges.rosbridge.ledger import Account
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
    receives them later. credit: maximum number of unacknowledged messages, or None. fragment_size: maximum number of
    characters in a frame of JSON, or None.
    """

    def __init__(
        self,
        topic: str,
        ros: Ros,
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
        self.longest = longest or default
        self.samples: deque[tuple[int, Sample]] = deque()
        self.bytes = 0
        self.next_s = float("-inf")
        self.lost = 0
        self._credit = credit
        self._unacknowledged = 0
        self._turn = math.inf  # of the oldest message that was dropped since the last one was sent
        self._cursor: Any = None  # for messages that build on each other

    @property
    def turn(self) -> float:
        """The order in which it is served: newer messages inherit that of those dropped, lest a fast topic starve."""
        return min(self._turn, self.samples[0][0])

    @property
    def is_blocked(self) -> bool:
        """Whether the client must acknowledge messages before more are sent."""
        return self._credit is not None and self._unacknowledged >= self._credit

    def acknowledge(self, count: int) -> None:
        """Restore credit for acknowledged messages."""
        self._unacknowledged = max(0, self._unacknowledged - count)

    def put(self, order: int, sample: Sample, now_s: float, account: Account, most_bytes: float) -> None:
        """Queue a sample, dropping the oldest samples if there are too many or they take too many bytes."""
        if self.drops_early and now_s < self.next_s and not sample.builds_up:
            return
        if sample.builds_up:
            self.clear(account)  # the new sample contains their content
        while self.samples and (len(self.samples) >= self.longest or self.bytes + sample.size > most_bytes):
            self.lost += 1
            self._turn = min(self._turn, self.samples[0][0])
            self._pop(account)
        self.samples.append((order, sample))
        self.bytes += sample.size
        account.hold(sample)

    def take(self, now_s: float, account: Account) -> Parcel:
        """Remove the oldest sample from the queue and return it."""
        self.next_s, self._turn = now_s + self.throttle_s, math.inf
        self._unacknowledged += 1
        sample, self._cursor = self._pop(account).after(self._cursor)
        return Parcel(sample, self.topic, self.ros, self.compression, self._fragment_size)

    def clear(self, account: Account) -> None:
        """Drop everything in the queue."""
        while self.samples:
            self._pop(account)

    def _pop(self, account: Account) -> Sample:
        sample = self.samples.popleft()[1]
        self.bytes -= sample.size
        account.drop(sample)
        return sample


class Outbox:
    """A client's queues. wake: called when there is something to send. account: charged for the size of the queues."""

    def __init__(self, limits: Limits, account: Account, clock: Callable[[], float], wake: Callable[[], None]) -> None:
        self._limits = limits
        self._account = account
        self._clock = clock
        self._replies: deque[tuple[Frame, int | None]] = deque()
        self._rest: Iterator[str] = iter(())  # the remaining fragments of the current frame
        self._rest_bytes = 0
        self._fragmented = 0
        self._mailboxes: dict[Any, Mailbox] = {}
        self._order = 0
        self._wake = wake
        self._is_shut = False

    def reply(self, frame: Frame, fragment_size: int | None = None) -> None:
        """Queue an answer, to be sent in fragments if it is JSON longer than fragment_size.

        A client with too many unread answers is disconnected.
        """
        if self._is_shut:
            return
        if len(self._replies) >= self._limits.replies:
            self._account.give_up(f"{len(self._replies)} answers are waiting to be read, the maximum")
            return
        self._replies.append((frame, fragment_size))
        self._account.take(sys.getsizeof(frame))
        if self._account.is_over:
            self._check_bytes()
        self._wake()

    def _check_bytes(self) -> None:
        """Disconnect a client that is over its limit, unless only one message (of any size) is queued."""
        waiting = len(self._replies) + sum(len(mailbox.samples) for mailbox in self._mailboxes.values())
        if waiting > 1:
            size, most = self._account.bytes / 1e6, self._account.limit / 1e6
            self._account.give_up(f"{size:.0f} MB wait to be read, of {most:.0f} that may: you read too slowly")

    def open(self, key: Any, mailbox: Mailbox) -> None:
        """Add a subscription's queue, or replace it."""
        self.close(key)
        self._mailboxes[key] = mailbox

    def close(self, key: Any) -> None:
        """Remove a subscription's queue and its contents."""
        mailbox = self._mailboxes.pop(key, None)
        if mailbox is not None:
            mailbox.clear(self._account)

    def shut(self) -> None:
        """Drop everything and ignore further messages."""
        self._is_shut = True
        for key in list(self._mailboxes):
            self.close(key)
        self._replies.clear()
        self._rest = iter(())

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
            mailbox.put(self._order, sample, self._clock(), self._account, self._limits.mailbox_bytes)
            if self._account.is_over:
                self._check_bytes()
            self._wake()

    @property
    def lost(self) -> int:
        """The number of messages of current subscriptions that were dropped in favour of newer ones."""
        return sum(mailbox.lost for mailbox in self._mailboxes.values())

    def pick(self) -> tuple[Frame | Parcel | None, float | None]:
        """Return the next frame or parcel to send.

        If there is none, return None and the seconds until a throttled message is due (None without one). The frame of
        a parcel must be passed to `begun`.
        """
        fragment = next(self._rest, None)
        if fragment is not None:
            return fragment, None
        self._account.give(self._rest_bytes)
        self._rest_bytes = 0
        if self._replies:
            frame, fragment_size = self._replies.popleft()
            self._account.give(sys.getsizeof(frame))
            return self.begun(frame, fragment_size), None
        now_s = self._clock()
        waiting = [mailbox for mailbox in self._mailboxes.values() if mailbox.samples and not mailbox.is_blocked]
        due = [mailbox for mailbox in waiting if mailbox.next_s <= now_s]
        if due:
            return min(due, key=_turn).take(now_s, self._account), None
        return None, min((mailbox.next_s - now_s for mailbox in waiting), default=None)

    def begun(self, frame: Frame, fragment_size: int | None) -> Frame:
        """Return a frame or, for text longer than fragment_size, its first fragment. `pick` returns the rest."""
        if fragment_size is None or isinstance(frame, bytes) or len(frame) <= fragment_size:
            return frame
        self._fragmented += 1
        self._rest = split(frame, fragment_size, str(self._fragmented), self._limits.fragments)
        self._rest_bytes = sys.getsizeof(frame)
        self._account.take(self._rest_bytes)
        return next(self._rest)

    def take(self) -> tuple[Frame | None, float | None]:
        """Do the same as `pick`, but return the encoded frame."""
        found, delay_s = self.pick()
        return self.begun(found.encode(), found.fragment_size) if isinstance(found, Parcel) else found, delay_s


def _turn(mailbox: Mailbox) -> float:
    return mailbox.turn
