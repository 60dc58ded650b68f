"""trimesh, imported whole: a Ctrl-C during its import is handled after it.

cascadio 0.1.1, which trimesh imports where it is installed, crashes when KeyboardInterrupt is raised while its module
is created, and trimesh 5.2 keeps any exception of an optional import, KeyboardInterrupt as well, as a broken module.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

__all__ = ["trimesh"]


@contextmanager
def _interrupts_held() -> Iterator[None]:
    before = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(before):
        yield  # only the main thread receives signals; not callable: ignored, or of a host program
        return
    received: list[int] = []

    def note(number: int, _: FrameType | None) -> None:
        received.append(number)

    signal.signal(signal.SIGINT, note)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if received:
        signal.raise_signal(signal.SIGINT)


with _interrupts_held():
    import trimesh
