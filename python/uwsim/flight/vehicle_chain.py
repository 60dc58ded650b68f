"""How a vehicle builds a map: the processing chain from pings to map, the ping rate, and the requirements."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from uwsim.base.wall_timer import WallTimer
from uwsim.flight.stages import CODEC
from uwsim.mapping.map_filler import MapFiller
from uwsim.mapping.ping_to_map import PingToMap, depth_string
from uwsim.scenario import Scenario, ScenarioError
from uwsim.scenario.build.ping_chain import map_voxel_m, ping_chain
from uwsim.simulator.simulator import Simulator

PING_RATE_HZ = 10.0  # for scenarios without a survey
Array = NDArray[np.float64]


def chain_of(
    sim: Simulator,
    vehicle: str,
    filler: MapFiller,
    filters: bool,
    *,
    timer: WallTimer | None = None,
    transmit: Callable[[str], str] | None = None,
) -> PingToMap:
    """Return the processing chain from a vehicle's pings to a map. filters: whether to discard outliers."""
    (entry,) = (entry for entry in sim.scenario.vehicles if entry.name == vehicle)
    sonar = sim.vehicles[vehicle].sonar
    wire = depth_string(sonar.model, transmit)
    return ping_chain(
        sim.scenario,
        entry.model,
        sonar.model,
        in_physics=sonar.mode == "physics",
        outlier_filter=filters,
        voxel_m=filler.occupancy.resolution_m,
        filler=filler,
        wire=wire if timer is None else timer.timed(CODEC, wire),
    )


def filters_outliers(sim: Simulator, vehicle: str, asked: bool | None) -> bool:
    """Return whether to filter outliers: as requested, else as the scenario specifies, else only in physics mode.

    Raises ScenarioError if the scenario limits uncertainties that the sonar does not provide.
    """
    survey, in_physics = sim.scenario.survey, sim.vehicles[vehicle].sonar.mode == "physics"
    if survey is not None and survey.max_uncertainty_m is not None and not in_physics:
        with sim.scenario.source_file.errors_at("survey", "max_uncertainty_m"):
            raise ScenarioError(
                f"survey.max_uncertainty_m = {survey.max_uncertainty_m:g} m: needs a sonar with `mode: physics`"
            )
    if asked is None and survey is not None:
        asked = survey.outlier_filter
    return in_physics if asked is None else asked


def requested_interval_s(sim: Simulator) -> float:
    """Return the time between pings requested by the scenario."""
    return 1.0 / (PING_RATE_HZ if sim.scenario.survey is None else sim.scenario.survey.ping_rate_hz)


def ping_interval_s(sim: Simulator, vehicle: str) -> float:
    """Return the scenario's ping interval, or the two-way travel time, rounded up to whole steps, if that is longer."""
    least_s = 1.0 / sim.vehicles[vehicle].sonar.ping_rate_max_hz
    return max(requested_interval_s(sim), math.ceil(least_s / sim.step_s) * sim.step_s)


def ping_steps(sim: Simulator, vehicle: str) -> int:
    """Return the number of steps between pings: the ping interval in steps, never below the travel time."""
    return max(1, round(ping_interval_s(sim, vehicle) / sim.step_s))


def survey_area_m(sim: Simulator) -> Array | None:
    """Return the polygon (k, 2) of the scenario's survey, if it has one."""
    return None if sim.scenario.survey is None else np.asarray(sim.scenario.survey.area_m, np.float64)


def default_voxel_m(sim: Simulator) -> float:
    """Return the scenario's voxel edge length."""
    return map_voxel_m(sim.scenario)


def require_sonar(scenario: Scenario, vehicle: str) -> None:
    """Raise ValueError unless the vehicle has a sonar for mapping."""
    if any(entry.name == vehicle and entry.model.sonar is None for entry in scenario.vehicles):
        raise ValueError(f"vehicle '{vehicle}': carries no sonar to map with")
