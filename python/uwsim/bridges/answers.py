"""Runs service calls on separate threads. Each call is answered exactly once, with values or a reason for failure."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from logging import Logger
from typing import Any

Answer = Callable[[bool, Any], object]
"""Receives whether a call succeeded, and its values or the reason for its failure."""


def outcome(call: Callable[[], Any], log: Logger) -> tuple[bool, Any]:
    """Run a call; return whether it succeeded, and its values or the reason for its failure. Never raises."""
    try:
        return True, call()
    except CancelledError:
        return False, "the server stops"
    except (ValueError, RuntimeError) as error:
        return False, str(error) or type(error).__name__
    except Exception as error:
        log.exception("a service failed")
        return False, str(error) or type(error).__name__


class Lane:
    """A pool of threads for calls that may block. most: maximum number of unanswered calls, or None."""

    def __init__(self, name: str, threads: int, log: Logger, most: int | None = None) -> None:
        self._pool = ThreadPoolExecutor(threads, thread_name_prefix=name)
        self._log = log
        self._most = most
        self._free = None if most is None else threading.Semaphore(most)

    def submit(self, call: Callable[[], Any], answer: Answer) -> None:
        """Run a call on one of the threads, and send the answer from that thread; after `close`, it fails at once.

        Raises ValueError if too many calls are waiting.
        """
        if self._free is not None and not self._free.acquire(blocking=False):
            raise ValueError(f"{self._most} calls are already waiting: this one is refused")

        def finish(done: Future[Any]) -> None:
            if self._free is not None:
                self._free.release()
            answer(*outcome(done.result, self._log))

        try:
            begun = self._pool.submit(call)
        except RuntimeError:  # closed: clients may still call while the server stops
            begun = Future()
            begun.cancel()
        begun.add_done_callback(finish)

    def close(self) -> None:
        """Stop starting calls; queued calls fail."""
        self._pool.shutdown(wait=False, cancel_futures=True)
