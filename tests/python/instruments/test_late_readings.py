"""A sample does not depend on when it is read: late or at once, it has the same bytes."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.scenario.load import packaged_scenarios

SMALL = ("lake_boat", "kelp", "pair")  # a station that moves, plants that sway, vehicles that move
LATE_STEPS = 37


def flown(name: str, flown_s: float) -> Iterator[Simulator]:
    """Yield a simulator before each step; in the middle, its water and an instrument's errors change."""
    sim = Simulator(name, threads=1)
    steps = round(flown_s / sim.step_s)
    for hull in sim.vehicles.values():
        if not hull.released:
            hull.undock()
        hull.set_effort(surge=0.7, yaw=0.2)
    for k in range(steps):
        if k == steps // 2:
            sim.parameters["water.bottom_temperature_deg_c"] = 3.0
            for hull in sim.vehicles.values():
                for sensor in hull.sensors.values():
                    sim.parameters[f"{hull.name}.sensors.{sensor.name}.latency_s"] = 0.07
        yield sim
        sim.step()


def samples(sim: Simulator) -> Iterator[tuple[tuple[str, str, int], bytes]]:
    """Yield the newest sample of each sensor, by vehicle, sensor and stamp; nothing before one has arrived."""
    for hull in sim.vehicles.values():
        for sensor in hull.sensors.values():
            sample: Any = sensor.sample()
            if sample.valid:
                parts = [sample.value] if np.isscalar(sample.value) else vars(sample.value).values()
                yield (hull.name, sensor.name, sample.stamp_ns), np.hstack([np.ravel(part) for part in parts]).tobytes()


def require_same(name: str, flown_s: float = 5.0) -> None:
    at_once: dict[tuple[str, str, int], bytes] = {}
    for sim in flown(name, flown_s):
        for key, value in samples(sim):
            assert at_once.setdefault(key, value) == value, f"{key} changes"
    late: dict[tuple[str, str, int], bytes] = {}
    for k, sim in enumerate(flown(name, flown_s)):
        if k % LATE_STEPS == 19:
            sim.restore_state(sim.save_state())  # the samples to come are part of the state
            late |= samples(sim)
    assert late
    assert sorted(key for key, value in late.items() if at_once[key] != value) == []


@pytest.mark.parametrize("name", SMALL)
def test_a_sample_is_the_same_whenever_it_is_read(name: str) -> None:
    require_same(name, 2.2)  # two fixes of a USBL


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", [each for each in packaged_scenarios() if each not in SMALL])
def test_every_sample_of_the_packaged_scenarios_is_the_same_whenever_it_is_read(name: str) -> None:
    require_same(name)
