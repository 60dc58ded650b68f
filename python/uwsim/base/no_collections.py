"""no_collections: pauses Python's garbage collector for a short time."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def no_collections() -> Iterator[None]:
    """Pause garbage collection during the block, if it is on.

    For blocks that run once and create many lasting objects, as imports do: collections would take up to a fifth of the
    time and find nothing. Afterwards the objects count as old, so that the next collection need not visit them either.
    Not for blocks that run repeatedly: their garbage would be found late.
    """
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            if gc.get_freeze_count() == 0:  # there are no frozen objects, which unfreeze() would release
                gc.freeze()
                gc.unfreeze()  # into the oldest generation
            gc.enable()
