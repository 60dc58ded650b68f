"""no_collections: pauses Python's garbage collector for a short time."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def no_collections() -> Iterator[None]:
    """Pause garbage collection during the block, if it is on.

    For blocks that create many lasting objects, as imports do: collections would take up to a fifth of the time and
    find nothing.
    """
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()
