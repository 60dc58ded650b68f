"""Wall time by stage of a survey: physics, rays, codec, conversion, map and others."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

STAGES = ("physics", "rays", "codec", "conversion", "map")
WAITING = "waiting for the map"  # time of the flying thread, where the map has a thread of its own
AUTOSAVE, VERIFICATION = "autosave", "verification"  # present only when used
MAP_THREAD_STAGES = ("map", VERIFICATION, AUTOSAVE)  # run on the map's thread, where it has one


class WallTimer:
    """Adds up wall seconds by stage, starting from those of an earlier flight. Each stage is timed by one thread."""

    def __init__(self, wall_s: Mapping[str, float] | None = None) -> None:
        self.wall_s = {**dict.fromkeys((*STAGES, WAITING), 0.0), **(wall_s or {})}

    @contextmanager
    def measure(self, stage: str) -> Iterator[None]:
        """Add the wall time of the block to a stage."""
        start_s = time.perf_counter()
        try:
            yield
        finally:
            self.wall_s[stage] = self.wall_s.get(stage, 0.0) + time.perf_counter() - start_s
