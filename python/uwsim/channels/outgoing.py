"""Outgoing messages, from the simulator's thread to a network: bounded queues, and the thread that writes."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable
from queue import SimpleQueue

from uwsim.channels.message_types import NEWEST_ONLY

QUEUE = 10  # messages per topic that may wait to be written
LARGE_QUEUE = 2
CLOSE_S = 5.0

logger = logging.getLogger("uwsim.channels")


def queue_of(type_name: str) -> int:
    """Return the number of messages of a type that may wait to be written; smaller for large messages."""
    return LARGE_QUEUE if type_name in NEWEST_ONLY else QUEUE


class Line:
    """One topic's queue of jobs. length: the number of jobs that may wait.

    A job encodes and writes a message, and returns whether it was accepted. written: the number of messages written.
    dropped: the number of messages that were dropped for newer ones or not accepted.
    """

    def __init__(self, name: str, length: int) -> None:
        self.name = name
        self.length = length
        self.waiting: deque[Callable[[], bool]] = deque()
        self.written = 0
        self.dropped = 0


class Outgoing:
    """Runs jobs on a separate thread in order of arrival. Offering a job never blocks."""

    def __init__(self, thread_name: str) -> None:
        self._lock = threading.Lock()
        self._turns: SimpleQueue[Line | None] = SimpleQueue()
        self._is_closed = False
        self._thread = threading.Thread(target=self._run, name=thread_name, daemon=True)
        self._thread.start()

    def offer(self, line: Line, job: Callable[[], bool]) -> None:
        """Queue a message, from any thread. If the queue is full, its oldest message is dropped."""
        with self._lock:
            line.waiting.append(job)
            if len(line.waiting) > line.length:
                line.waiting.popleft()
                line.dropped += 1
                return  # it takes the turn of the dropped message
        self._turns.put(line)

    def close(self) -> None:
        """Stop after the message that is being written."""
        self._is_closed = True
        self._turns.put(None)
        self._thread.join(CLOSE_S)

    def _run(self) -> None:
        while True:
            line = self._turns.get()
            if line is None or self._is_closed:
                return
            with self._lock:
                job = line.waiting.popleft()
            try:
                if job():
                    line.written += 1
                else:
                    line.dropped += 1
            except Exception:
                line.dropped += 1
                logger.exception("topic '%s': a message could not be written", line.name)
