"""Wall time by stage of a survey: physics, rays, codec, conversion, mission, map and others."""

from __future__ import annotations

import time
from collections.abc import Mapping

MISSION = "mission"  # its own code, from the end of a wait to the next one
STAGES = ("physics", "rays", "codec", "conversion", MISSION, "map")
WAITING = "waiting for the map"  # time of the flying thread, where the map has a thread of its own
AUTOSAVE, VERIFICATION = "autosave", "verification"  # present only when used
MAP_THREAD_STAGES = ("map", VERIFICATION, AUTOSAVE)  # run on the map's thread, where it has one


class WallTimer:
    """Adds up wall seconds by stage, starting from those of an earlier flight. Each stage is timed by one thread."""

    def __init__(self, wall_s: Mapping[str, float] | None = None) -> None:
        self.wall_s = {**dict.fromkeys((*STAGES, WAITING), 0.0), **(wall_s or {})}
        self._measurements: dict[str, Measurement] = {}

    def measure(self, stage: str) -> Measurement:
        """Add the wall time of a `with` block to a stage. Blocks of one stage are not nested."""
        measurement = self._measurements.get(stage)
        if measurement is None:
            measurement = self._measurements[stage] = Measurement(self.wall_s, stage)
        return measurement

    def add(self, stage: str, elapsed_s: float) -> None:
        """Add seconds to a stage."""
        self.wall_s[stage] += elapsed_s


class Measurement:
    """Adds to a stage what a `with` block takes.

    Faster than a generator's context manager: there are several in each ping.
    """

    __slots__ = ("_stage", "_start_s", "_wall_s")

    def __init__(self, wall_s: dict[str, float], stage: str) -> None:
        self._wall_s, self._stage = wall_s, stage
        wall_s.setdefault(stage, 0.0)

    def __enter__(self) -> None:
        self._start_s = time.perf_counter()

    def __exit__(self, *_: object) -> None:
        self._wall_s[self._stage] += time.perf_counter() - self._start_s
