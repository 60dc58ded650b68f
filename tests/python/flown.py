"""A short recorded flight, for tests of what is done with recordings."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from uwsim import Simulator
from uwsim.recording import Recorder
from uwsim.scenario import Scenario, load
from uwsim.scenario.dump import plain
from uwsim.scenario.read.validated import validated

FLOWN_S = 6.0


def with_small_cameras() -> Scenario:
    """Return the pool with cameras of few pixels, for tests of when they are read, not what they see."""
    values = plain(load("pool"))
    for camera in values["vehicles"][0]["model"]["cameras"].values():
        camera |= {"width": 96, "height": 54}
    return validated(Scenario, values)


def fly(
    path: Path, yaw: float = 0.2, recorder: type[Recorder] = Recorder, end_s: float = FLOWN_S, **options: Any
) -> Path:
    """Fly in the pool with changing efforts, recorded with options to a path, which is returned."""
    sim = Simulator("pool", seed=3)
    with recorder(sim, path, is_light=True, **options):
        sim.rov.undock()
        for k in range(int(2 * end_s)):
            sim.rov.set_effort(surge=0.4, yaw=yaw * (k % 3))
            sim.rov.lamps["front"].on = bool(k % 2)
            sim.advance(0.5)
    return path
