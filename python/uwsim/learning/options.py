"""Validated options for the episodes of an environment."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from uwsim.base.named import did_you_mean
from uwsim.batch.arguments import FaultList
from uwsim.learning.task import Task
from uwsim.scenario import AnyScenario, Scenario
from uwsim.scenario.spec.fault import FaultModel, Observer
from uwsim.simulator.parameters import Parameters

Ranges = Mapping[str, tuple[float, float]]
PICTURE_MAX = 1024


@dataclass(frozen=True)
class EpisodeOptions:
    """Options common to all environments.

    scenario: replaces the task's scenario, and must contain what the task needs. randomize: (low, high) by name in
    `Simulator.parameters`; values are drawn uniformly for each episode. They add to the task's own ranges and override
    those of the same name. duration_s: time after which an episode is truncated. threads: defaults to all. camera: name
    of a vehicle camera whose pictures, of camera_size (height, width), are added to the observation. faults: these
    replace the scenario's faults in each episode and have the same keys; random faults (rate_per_h) are drawn for each
    episode. sonar_mode: mode of the task's sonar, "geometry" or "physics". normalise: whether the observed values are
    divided by the usual sizes of their fields; otherwise they have the fields' units.
    """

    scenario: AnyScenario | None = None
    randomize: Ranges | None = None
    duration_s: float | None = None
    threads: int | None = None
    camera: str | None = None
    camera_size: tuple[int, int] = (84, 84)
    faults: FaultList | None = None
    sonar_mode: Literal["geometry", "physics"] | None = None
    normalise: bool = True

    def __post_init__(self) -> None:
        """Check all options that can be checked without the scenario. Raises ValueError if one is invalid."""
        if self.duration_s is not None and not 0.0 < self.duration_s < math.inf:
            raise ValueError(f"duration_s = {self.duration_s} s: must be positive and finite")
        height, width = self.camera_size
        if not (1 <= height <= PICTURE_MAX and 1 <= width <= PICTURE_MAX):
            raise ValueError(f"camera_size = {self.camera_size}: must be in [1, {PICTURE_MAX}] pixels")
        if self.camera is None and self.camera_size != (84, 84):
            raise ValueError("camera_size: has no effect: no camera is selected")


def in_sonar_mode(scenario: Scenario, kind: type[Task], mode: str) -> Scenario:
    """Return the scenario with its first vehicle's sonar in this mode. Raises ValueError if the task uses no sonar."""
    if not kind.pings:
        raise ValueError(f"sonar_mode = {mode!r}: has no effect: {kind.__name__} uses no sonar")
    parameters = Parameters(scenario, lambda _: None, lambda *_, **__: None, {})
    parameters.update({f"{scenario.vehicles[0].name}.sonar.mode": mode})
    return parameters.scenario


def require_effect(faults: Sequence[FaultModel], kind: type[Task], scenario: Scenario, camera: str | None) -> None:
    """Raise ValueError for faults that affect neither the task nor a failsafe. camera: the observed camera, if any."""
    failsafes = [entry.failsafe or entry.model.failsafe for entry in scenario.vehicles]
    watches_sensors = any(failsafe and failsafe.sensor_then for failsafe in failsafes)
    observer = Observer(kind.__name__, kind.sensors, watches_sensors, camera, kind.pings, scenario.link is not None)
    for index, fault in enumerate(faults):
        if reason := fault.unnoticed(observer):
            raise ValueError(f"faults[{index}]: would have no effect: {reason}")


def checked_ranges(ranges: Ranges, scenario: Scenario) -> dict[str, tuple[float, float]]:
    """Return the validated ranges. Raises ValueError unless names are parameters of the scenario and low <= high."""
    parameters = Parameters(scenario, lambda _: None, lambda *_, **__: None, {})
    names = list(parameters)
    checked = {}
    for name, pair in ranges.items():
        if name not in names:
            raise ValueError(f"randomize[{name!r}]: is not a parameter{did_you_mean(name, names)}")
        try:
            low, high = (float(end) for end in pair)
        except (TypeError, ValueError):
            raise ValueError(f"randomize[{name!r}] = {pair!r:.60}: must be (low, high)") from None
        if not low <= high:
            raise ValueError(f"randomize[{name!r}] = ({low:g}, {high:g}): low must not exceed high")
        parameters.update({name: low})
        parameters.update({name: high})
        checked[name] = (low, high)
    return checked
