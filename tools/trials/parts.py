"""Parts that the trials share: a program that runs aside, and a simulator that is connected to it."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np

from uwsim import Simulator
from uwsim.bridges.aboard.aboard import aboard_of
from uwsim.bridges.plug import Context
from uwsim.channels.delivery.feed import Feed
from uwsim.channels.served import served_table
from uwsim.live import LiveSimulator
from uwsim.scenario import Scenario
from uwsim.scenario.read.validated import validated


def bay(depth_m: float, density_kg_m3: float, latitude_deg: float, longitude_deg: float) -> dict[str, Any]:
    """Return an empty bay as a scenario without vehicles; its station is near, for the fixes of its USBL."""
    return {
        "name": "bay", "description": "an empty bay", "mission_time_s": 3600, "water": {"density_kg_m3": density_kg_m3},
        "terrain": {"source": "noise", "size_m": [800, 800], "spacing_m": 10, "bed_depth_m": depth_m},
        "station": {"position_m": [60, -70, 0], "dock_m": [0, 0, -2]},
        "earth": {"latitude_deg": latitude_deg, "longitude_deg": longitude_deg},
    }  # fmt: skip


@contextmanager
def flown(scenario: dict[str, Any], plug: Any, speed: float = 1.0) -> Iterator[LiveSimulator]:
    """Run a simulator with a bridge's plug."""
    with LiveSimulator(Simulator(validated(Scenario, scenario), seed=1), speed=speed) as live:
        table = served_table(live, wire=None, origin="world", tf="truth", frame_prefix="")
        context = Context(table.channels, Feed(live), live, aboard=aboard_of(live.simulator, table))
        with plug.open(context):
            yield live


@contextmanager
def running(
    command: Sequence[str], work: Path, log: Path, environment: Mapping[str, str] | None = None
) -> Iterator[subprocess.Popen[bytes]]:
    """Run a program in a folder; end it, and all that it has launched."""
    with log.open("wb") as output:
        process = subprocess.Popen(
            command, cwd=work, env=environment, stdout=output, stderr=output, stdin=subprocess.DEVNULL,
            start_new_session=True,
        )  # fmt: skip
        try:
            yield process
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGINT)
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()


def nearest_m(track: np.ndarray[Any, Any], points_m: Sequence[Sequence[float]]) -> list[float]:
    """Return how near a track (n, 2) comes to each point."""
    return [float(np.linalg.norm(track - each, axis=1).min()) for each in points_m]


def shown(values: Sequence[float]) -> str:
    """Return distances as a text."""
    return ", ".join(f"{each:.1f}" for each in values)
