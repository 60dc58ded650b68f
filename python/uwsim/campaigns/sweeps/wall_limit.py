"""A wall time limit for a thread that may hang, for example in a mission that never waits."""

from __future__ import annotations

import ctypes
import threading
from collections.abc import Iterator
from contextlib import contextmanager

AGAIN_S = 1.0


class WallLimitError(BaseException):
    """A run took longer than wall_limit_s. Not an Exception, which a mission might catch."""


@contextmanager
def wall_limit(limit_s: float | None) -> Iterator[None]:
    """Raise WallLimitError in this thread once the block has run for limit_s; None means no limit.

    Python raises it between two bytecode instructions, so that C++ calls are not interrupted.
    """
    if limit_s is None:
        yield
        return
    ended, lock, thread = threading.Event(), threading.Lock(), threading.get_ident()

    def watch() -> None:
        pause_s = limit_s
        while not ended.wait(pause_s):
            with lock:
                if not ended.is_set():
                    ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), ctypes.py_object(WallLimitError))
            pause_s = AGAIN_S  # a `finally` or a bare `except` may have swallowed it

    watcher = threading.Thread(target=watch, name="wall-limit", daemon=True)
    watcher.start()
    try:
        try:
            yield
        finally:
            with lock:
                ended.set()
    except WallLimitError:
        raise WallLimitError(f"took longer than wall_limit_s = {limit_s:g} s") from None
