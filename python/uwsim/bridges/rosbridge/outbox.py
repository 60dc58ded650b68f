"""The messages that wait to be sent to one client: answers first, then each subscription's messages, in bounded memory.

A client that does not read loses the oldest messages of its own subscriptions, and nobody else notices. Messages of
several topics leave in the order in which they came, unless one is throttled.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any

from uwsim.bridges.rosbridge.encoding import Compression, Frame, Sample
from uwsim.channels.messages import Ros

DEFAULT_QUEUE = 10
LARGE_QUEUE = 8


class Mailbox:
    """One subscription's queue. throttle_s: least wall time between two messages. length: 0 for the default.

    As in rosbridge, a throttled subscription without a queue loses what comes too early; with one it gets it later.
    credit: messages that may be on their way without having been acknowledged; None: any number.
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
    ) -> None:
        self.topic = topic
        self.ros: Ros = ros
        self.compression: Compression = compression
        self.throttle_s = throttle_s
        self.drops_early = throttle_s > 0 and length == 0
        default = 1 if large or self.drops_early else DEFAULT_QUEUE
        longest = min(length, LARGE_QUEUE) if large else length
        self.samples: deque[tuple[int, Sample]] = deque(maxlen=longest or default)
        self.next_s = float("-inf")
        self.lost = 0
        self._credit = credit
        self._unacknowledged = 0
        self._cursor: Any = None  # of messages that build on each other

    @property
    def is_blocked(self) -> bool:
        """Whether the client must acknowledge before it gets more."""
        return self._credit is not None and self._unacknowledged >= self._credit

    def acknowledge(self, count: int) -> None:
        """Give credit back."""
        self._unacknowledged = max(0, self._unacknowledged - count)

    def put(self, order: int, sample: Sample, now_s: float) -> None:
        """Queue a sample; the oldest one gives way."""
        if self.drops_early and now_s < self.next_s and not sample.builds_up:
            return
        if sample.builds_up:
            self.samples.clear()  # the new one says what they would have said
        elif len(self.samples) == self.samples.maxlen:
            self.lost += 1
        self.samples.append((order, sample))

    def take(self, now_s: float) -> Frame:
        """Encode the oldest sample."""
        self.next_s = now_s + self.throttle_s
        self._unacknowledged += 1
        sample, self._cursor = self.samples.popleft()[1].after(self._cursor)
        return sample.frame(self.topic, self.ros, self.compression)


class Outbox:
    """A client's queues. wake is called when there is something to send, give_up when too many answers wait."""

    def __init__(
        self, replies: int, clock: Callable[[], float], wake: Callable[[], None], give_up: Callable[[], None]
    ) -> None:
        self._limit = replies
        self._clock = clock
        self._replies: deque[Frame] = deque()
        self._mailboxes: dict[Any, Mailbox] = {}
        self._order = 0
        self._wake = wake
        self._give_up = give_up

    def reply(self, frame: Frame) -> None:
        """Queue an answer. If too many wait, the client asks on and does not read: it is given up."""
        if len(self._replies) >= self._limit:
            self._give_up()
        else:
            self._replies.append(frame)
            self._wake()

    def open(self, key: Any, mailbox: Mailbox) -> None:
        """Add a subscription's queue, or replace it."""
        self._mailboxes[key] = mailbox

    def close(self, key: Any) -> None:
        """Drop a subscription's queue with what waits in it."""
        self._mailboxes.pop(key, None)

    def acknowledge(self, key: Any, count: int) -> None:
        """Take note that a subscription's client has dealt with messages."""
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
            self._wake()

    @property
    def lost(self) -> int:
        """Messages that gave way to newer ones, of the present subscriptions."""
        return sum(mailbox.lost for mailbox in self._mailboxes.values())

    def take(self) -> tuple[Frame | None, float | None]:
        """Return the next frame; or None and the seconds until a throttled one is due, None if nothing waits."""
        if self._replies:
            return self._replies.popleft(), None
        now_s = self._clock()
        waiting = [mailbox for mailbox in self._mailboxes.values() if mailbox.samples and not mailbox.is_blocked]
        due = [mailbox for mailbox in waiting if mailbox.next_s <= now_s]
        if due:
            return min(due, key=_age).take(now_s), None
        return None, min((mailbox.next_s - now_s for mailbox in waiting), default=None)


def _age(mailbox: Mailbox) -> int:
    return mailbox.samples[0][0]
