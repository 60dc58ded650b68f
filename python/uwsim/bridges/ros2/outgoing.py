"""Messages on their way from the simulator's thread to DDS: bounded queues, and the thread that encodes and writes."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable
from queue import SimpleQueue

from uwsim.bridges.ros2.dds import RawWriter

logger = logging.getLogger("uwsim.ros2")
Encode = Callable[[], memoryview]


class Line:
    """One topic's queue. length: how many messages may wait.

    written, dropped: how many messages left, and how many gave way to newer ones.
    """

    def __init__(self, name: str, writer: RawWriter, length: int) -> None:
        self.name = name
        self.writer = writer
        self.length = length
        self.waiting: deque[Encode] = deque()
        self.written = 0
        self.dropped = 0


class Outgoing:
    """Writes messages on a thread of its own, in the order in which they came. Whoever offers never waits."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._turns: SimpleQueue[Line | None] = SimpleQueue()
        self._is_closed = False
        self._thread = threading.Thread(target=self._run, name="uwsim-ros2-write", daemon=True)
        self._thread.start()

    def offer(self, line: Line, encode: Encode) -> None:
        """Queue a message, from any thread; it is encoded when it is its turn. The oldest of a full queue gives way."""
        with self._lock:
            line.waiting.append(encode)
            if len(line.waiting) > line.length:
                line.waiting.popleft()
                line.dropped += 1
                return  # the turn of the one that gave way is this one's
        self._turns.put(line)

    def close(self) -> None:
        """End after the message that is being written."""
        self._is_closed = True
        self._turns.put(None)
        self._thread.join(5.0)

    def _run(self) -> None:
        while True:
            line = self._turns.get()
            if line is None or self._is_closed:
                return
            with self._lock:
                encode = line.waiting.popleft()
            try:
                if line.writer.write(encode()):
                    line.written += 1
                else:
                    line.dropped += 1
            except Exception:
                line.dropped += 1
                logger.exception("topic '%s': a message could not be written", line.name)
