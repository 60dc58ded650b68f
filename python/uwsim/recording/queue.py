"""The path from the simulator's thread to the file: a bounded queue, and a thread that empties it."""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from itertools import groupby
from typing import Any

from uwsim.recording.sink import Batch, Item, Sink

WAITING_BYTES = 64 << 20
"""Maximum number of queued bytes; beyond it, messages are dropped or, at maximum speed, steps wait."""
MESSAGE_BYTES = 200  # size of a queue entry, in addition to its data
FLUSH_S = 1.0
"""Wall time after which written data are passed to the operating system; a kill loses at most this much."""
GATHER_S = 0.1

logger = logging.getLogger("uwsim.recording")


class WritingQueue:
    """Messages waiting for a thread that writes them to a sink.

    error: the reason why nothing more can be written, such as a full disk. The simulation continues regardless.
    """

    def __init__(self, sink: Sink, limit_bytes: int = WAITING_BYTES) -> None:
        self.error: OSError | None = None
        self._sink = sink
        self._limit_bytes = limit_bytes
        self._items: deque[Item | Batch] = deque()
        self._bytes = 0
        self._changed = threading.Condition()
        self._ends = False
        self._thread = threading.Thread(target=self._write_all, name="uwsim-recording", daemon=True)
        self._thread.start()

    def put(self, item: Item, *, waits: bool, needed: bool = False) -> bool:
        """Queue a message; return whether it will be written.

        waits: whether to wait for space. needed: whether to queue it even if there is no space.
        """
        size = len(item[3]) + MESSAGE_BYTES
        with self._changed:
            while self._bytes + size > self._limit_bytes and self._items and not needed:
                if not waits or self.error is not None:
                    return False
                self._changed.wait()
            if self.error is not None:
                return False
            self._items.append(item)
            self._bytes += size
            if self._bytes > self._limit_bytes // 2:
                self._changed.notify_all()
        return True

    def put_all(self, messages: Batch) -> None:
        """Queue messages; wait while the queue is full. After an error, they are left out."""
        size = sum(map(len, messages.data)) + MESSAGE_BYTES * len(messages.data)
        with self._changed:
            while self._bytes > self._limit_bytes // 2 and self.error is None:
                self._changed.wait()
            if self.error is None:
                self._items.append(messages)
                self._bytes += size
                self._changed.notify_all()

    def close(self, end: Mapping[str, str]) -> None:
        """Write all queued messages and close the sink. Raises OSError if that fails or an earlier write failed."""
        with self._changed:
            self._ends = True
            self._changed.notify_all()
        self._thread.join()
        if self.error is not None:
            self._sink.abandon()
            raise self.error
        self._sink.close(end)

    def _write_all(self) -> None:
        flush_at_s = time.monotonic() + FLUSH_S
        while True:
            with self._changed:
                if not self._ends and self._bytes <= self._limit_bytes // 2:
                    self._changed.wait(GATHER_S)  # waking the thread for each message would slow down the steps
                items, self._items = self._items, deque[Item | Batch]()
                self._bytes = 0
                self._changed.notify_all()
                ends = self._ends and not items
            try:
                for batch in _batches(items):
                    self._sink.write(batch)
                if ends or time.monotonic() >= flush_at_s:
                    self._sink.flush()
                    flush_at_s = time.monotonic() + FLUSH_S
            except OSError as error:
                logger.error("the recording ends: %s", error.strerror or error)
                with self._changed:
                    self.error = error
                    self._items.clear()
                    self._changed.notify_all()
                return
            if ends:
                return


def _batches(items: Iterable[Item | Batch]) -> Iterator[Batch]:
    """Return batches in the same order, in which neighbouring messages are together."""
    for kind, group in groupby(items, key=type):
        together: list[Any] = list(group)
        yield from together if kind is Batch else [Batch.of(together)]
