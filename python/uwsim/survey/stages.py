"""Wall time by stage, so that one knows what to attack."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

STAGES = ("physics", "rays", "codec", "conversion", "map")
WAITING = "waiting for the map"  # of the flying thread, where the map has a thread of its own


class StageTimer:
    """Adds up wall seconds by stage. A stage is timed by one thread only."""

    def __init__(self) -> None:
        self.wall_s = dict.fromkeys((*STAGES, WAITING), 0.0)

    @contextmanager
    def measure(self, stage: str) -> Iterator[None]:
        """Adds the time that the block takes."""
        begun = time.perf_counter()
        try:
            yield
        finally:
            self.wall_s[stage] += time.perf_counter() - begun
