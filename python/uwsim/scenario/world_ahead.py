"""Builds the ray-tracing trees for a packaged scenario on a separate thread while the caller imports other modules."""

from __future__ import annotations

import resource
import threading
from contextlib import suppress
from pathlib import Path

from uwsim import _core
from uwsim.scenario.build.world import build_world
from uwsim.scenario.load import load, packaged_scenarios


def make_world_ahead(scenario: str | Path) -> None:
    """Start building the trees. A Simulator that needs them waits for them, since equal worlds share their trees.

    Only for packaged scenarios: errors in a user's scenario should be reported once, by the Simulator. Not if the
    address space is limited: a library that lacks memory on this thread may abort the process.
    """

    def make() -> None:
        with suppress(ValueError, OSError, MemoryError):  # the Simulator raises the same error
            _core.RayScene(build_world(load(scenario))).prepare()

    is_limited = resource.getrlimit(resource.RLIMIT_AS)[0] != resource.RLIM_INFINITY
    if str(scenario) in packaged_scenarios() and not is_limited:
        threading.Thread(target=make, name="world-ahead").start()
