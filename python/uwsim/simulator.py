"""The simulator's face: one object that holds a scenario's world and vehicles and advances them in fixed steps."""

from __future__ import annotations

import json
import os
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from uwsim import _core
from uwsim.assembly import vehicle_spec
from uwsim.fingerprint import build_fingerprint, scenario_fingerprint
from uwsim.imaging_mount import imaging_sonars
from uwsim.scenario import Scenario, build_world, load
from uwsim.scenario.build import backscatter_by_label
from uwsim.scenario.optics_spec import Optics
from uwsim.studio import Studio
from uwsim.vehicle import Vehicle

STEP_TOLERANCE = 1e-6  # of a step, by which a duration may miss a whole number of steps


class Simulator:
    """A scenario that runs.

    scenario: a packaged scenario's name ("lake"), the path of a YAML file, or a Scenario.
    seed, sonar_model (every vehicle's: 1 to 4, a packaged model's name or a path), sonar_frequency_khz (of a model that
    works at several), mission_time_s: replace the scenario's figures.
    threads: how many a survey may use; by default all. Results do not depend on it.
    Raises ScenarioError (a ValueError) that names file, line, key, value and rule.

    Reading, pinging and looking at telemetry do not advance time, and repeated at one time give the same sample.
    One call at a time owns the simulator; others wait. cameras: the station's, by name.
    """

    def __init__(
        self,
        scenario: str | Path | Scenario = "lake",
        *,
        seed: int | None = None,
        sonar_model: int | str | Path | None = None,
        sonar_frequency_khz: float | None = None,
        mission_time_s: float | None = None,
        threads: int | None = None,
    ) -> None:
        self.scenario = load(scenario).with_changes(
            seed=seed,
            mission_time_s=mission_time_s,
            sonar_model=sonar_model,
            sonar_frequency_khz=sonar_frequency_khz,
        )
        self.threads = _checked_threads(threads)
        self.world = build_world(self.scenario)
        self.scene = _core.RayScene(self.world)
        self._core = _core.Simulation(self.world, self.scene, _simulation_spec(self.scenario))
        self._studio = Studio(self.scenario, self.world, self.scene, self._core, self.threads)
        self.cameras = self._studio.station_cameras()
        self.vehicles: dict[str, Vehicle] = {}
        for vehicle in self.scenario.vehicles:
            spec = vehicle_spec(self.scenario, vehicle)
            index = self._core.add_vehicle(spec)
            cameras, lamps = self._studio.cameras_of(index), self._studio.lamps_of(index)
            self.vehicles[vehicle.name] = Vehicle(self._core, index, spec, cameras, lamps)
            self.vehicles[vehicle.name].imaging_sonars = imaging_sonars(self, vehicle)

    @property
    def rov(self) -> Vehicle:
        """The scenario's first vehicle."""
        return next(iter(self.vehicles.values()))

    @property
    def optics(self) -> Optics:
        """The light that cameras see by, as the scenario has it or as last set."""
        return self._studio.optics

    def set_optics(self, **changes: Any) -> None:
        """Change the light from now on, such as jerlov="5C" or sun_elevation_deg=2. Raises ValueError."""
        self._studio.optics = self._studio.optics.with_changes(changes)

    @property
    def strengths_db(self) -> dict[str, float]:
        """How much sound each surface scatters, by World.label_names, as its material has it; what pictures show."""
        surfaces = zip(self.world.label_names, backscatter_by_label(self.scenario), strict=True)
        return {name: surface.strength_db for name, surface in surfaces}

    @property
    def seed(self) -> int:
        """What every random draw is keyed by."""
        return self.scenario.seed

    @property
    def step_s(self) -> float:
        """The fixed step, seconds."""
        return self.scenario.step_s

    @property
    def time_ns(self) -> int:
        """Simulated time since the start, nanoseconds."""
        return self._core.time_ns

    @property
    def time_s(self) -> float:
        """Simulated time since the start, seconds."""
        return self.time_ns * 1e-9

    def step(self, n: int = 1) -> None:
        """Advance by n fixed steps. Raises ValueError when n is negative or a vehicle's motion diverges."""
        if isinstance(n, bool) or not isinstance(n, int | np.integer) or not 0 <= n < 2**63:
            raise ValueError(f"n = {n!r} steps: must be a whole number, not negative")
        self._core.step(int(n))

    def advance(self, duration_s: float) -> None:
        """Advance by a duration, which must be a whole number of steps. Raises ValueError."""
        steps = duration_s / self.step_s
        if not np.isfinite(steps) or steps < 0 or abs(steps - round(steps)) > STEP_TOLERANCE * max(1.0, steps):
            raise ValueError(f"duration_s = {duration_s} s: must be a whole number of steps of {self.step_s} s")
        self.step(round(steps))

    def wait(self, duration_s: float) -> None:
        """What a mission calls to let time pass: the simulator is its own clock. Same as advance."""
        self.advance(duration_s)

    def save_state(self) -> bytes:
        """All that the future depends on beside scenario and seed.

        That is motion, commands, clocks, sensors' memories, lamps and the light of set_optics. A Simulator of the same
        scenario, seed and build that restores it gives the same poses, samples and pictures to the last bit. What a
        mission or a map remembers is not in it.
        """
        lit = {name: {lamp.name: lamp.on for lamp in rov.lamps.values()} for name, rov in self.vehicles.items()}
        notes = json.dumps({"lamps": lit, "optics": self.optics.model_dump(mode="json")})
        return self._core.save_state(scenario_fingerprint(self.scenario), build_fingerprint(), notes)

    def restore_state(self, state: bytes) -> None:
        """Go on from what `save_state` gave.

        Raises ValueError, changing nothing, for a state that is damaged or of another scenario, seed or build.
        """
        if not isinstance(state, bytes):
            raise ValueError(f"state is {type(state).__name__}: must be bytes that save_state gave")
        notes = json.loads(self._core.restore_state(state, scenario_fingerprint(self.scenario), build_fingerprint()))
        for name, lamps in notes["lamps"].items():
            for lamp, on in lamps.items():
                self.vehicles[name].lamps[lamp].on = on
        self.set_optics(**notes["optics"])

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Nothing to release: the world lives as long as the object."""


def _checked_threads(threads: int | None) -> int:
    if threads is None:
        return len(os.sched_getaffinity(0))
    if isinstance(threads, bool) or not isinstance(threads, int | np.integer) or not 1 <= threads <= 1024:
        raise ValueError(f"threads = {threads!r}: must be a whole number in [1, 1024]")
    return int(threads)


def _simulation_spec(scenario: Scenario) -> _core.SimulationSpec:
    spec = _core.SimulationSpec()
    spec.step_s = scenario.step_s
    spec.seed = scenario.seed
    spec.mission_time_s = scenario.mission_time_s
    spec.station_world_m = scenario.station.position_m
    spec.range_warning_m = scenario.warnings.range_m
    spec.proximity_warning_m = scenario.warnings.proximity_m
    return spec
