"""Wall time by stage, so that one knows what to attack."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

STAGES = ("physics", "rays", "codec", "conversion", "map")
WAITING = "waiting for the map"  # of the flying thread, where the map has a thread of its own
AUTOSAVE, VERIFICATION = "autosave", "verification"  # listed where there are any
MAP_THREAD = ("map", VERIFICATION, AUTOSAVE)  # where the map has a thread of its own


class StageTimer:
    """Adds up wall seconds by stage, from what an earlier flight took. A stage is timed by one thread only."""

    def __init__(self, wall_s: Mapping[str, float] | None = None) -> None:
        self.wall_s = {**dict.fromkeys((*STAGES, WAITING), 0.0), **(wall_s or {})}

    @contextmanager
    def measure(self, stage: str) -> Iterator[None]:
        """Adds the time that the block takes."""
        begun = time.perf_counter()
        try:
            yield
        finally:
            self.wall_s[stage] = self.wall_s.get(stage, 0.0) + time.perf_counter() - begun
