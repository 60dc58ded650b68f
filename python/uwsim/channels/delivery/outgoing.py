"""Bounded queues and a writer thread for messages from the simulator's thread to a network."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable
from queue import Empty, SimpleQueue
from typing import Generic, TypeVar

from uwsim.channels.channel import Drops
from uwsim.channels.ros.message_types import NEWEST_ONLY

QUEUE = 10  # messages per topic that may wait to be written
LARGE_QUEUE = 2
CLOSE_S = 5.0

logger = logging.getLogger("uwsim.channels")
T = TypeVar("T")
Job = Callable[[], bool]
"""Encodes and writes a message; returns whether it was accepted."""


def queue_of(type_name: str) -> int:
    """Return the maximum number of queued messages of a type, which is smaller for large messages."""
    return LARGE_QUEUE if type_name in NEWEST_ONLY else QUEUE


class Line(Generic[T]):
    """One topic's queue. length: the maximum number of queued items.

    written: the number of messages written. drops: counts the messages that were dropped in favour of newer ones or not
    accepted.
    """

    def __init__(self, name: str, length: int, drops: Drops | None = None) -> None:
        self.name = name
        self.length = length
        self.waiting: deque[T] = deque()
        self.written = 0
        self.drops = drops or Drops()


class Turns(Generic[T]):
    """The items of several lines, in order of arrival.

    Any thread may call `put`, which never blocks; only one calls `take`. Each topic has its own line, so that frequent
    messages cannot displace the only message of a latched topic.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._order: SimpleQueue[Line[T] | None] = SimpleQueue()

    def put(self, line: Line[T], item: T) -> None:
        """Queue an item. If its line is full, the line's oldest item is dropped."""
        with self._lock:
            line.waiting.append(item)
            if len(line.waiting) > line.length:
                line.waiting.popleft()
                line.drops.add()
                return  # the new item takes the turn of the dropped one
        self._order.put(line)

    def take(self, *, wait: bool) -> tuple[Line[T], T] | None:
        """Return the next item and its line, or None if nothing is queued or `wake` has ended the wait."""
        try:
            line = self._order.get(block=wait)
        except Empty:
            return None
        if line is None:
            return None
        with self._lock:
            return line, line.waiting.popleft()

    def __len__(self) -> int:
        return self._order.qsize()

    def wake(self) -> None:
        """End a wait, from any thread."""
        self._order.put(None)


class Outgoing:
    """Runs jobs on a separate thread in order of arrival. Offering a job never blocks."""

    def __init__(self, thread_name: str) -> None:
        self._turns: Turns[Job] = Turns()
        self._is_closed = False
        self._thread = threading.Thread(target=self._run, name=thread_name, daemon=True)
        self._thread.start()

    def offer(self, line: Line[Job], job: Job) -> None:
        """Queue a message, from any thread. If the queue is full, its oldest message is dropped."""
        self._turns.put(line, job)

    def close(self) -> None:
        """Stop once the current message has been written."""
        self._is_closed = True
        self._turns.wake()
        self._thread.join(CLOSE_S)

    def _run(self) -> None:
        while (turn := self._turns.take(wait=True)) is not None and not self._is_closed:
            line, job = turn
            try:
                if job():
                    line.written += 1
                else:
                    line.drops.add()
            except Exception:
                line.drops.add()
                logger.exception("topic '%s': a message could not be written", line.name)
