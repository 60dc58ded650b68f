"""Checks navigation in waves: small errors, which match the filter's covariance, in every sea and for every hull.

The pressure of waves moves a depth gauge's reading by up to a decimetre per decimetre of wave, while the vehicle
follows the water's orbit. The flights are those of estimation.py, in the lagoon, near the surface; each flight in a sea
is that of the next packaged vehicle that carries a DVL. The measure is the NEES of estimation.py.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import cycle
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.axes import AXES
from uwsim.evidence.validate.check import Check, at_most
from uwsim.evidence.validate.consistency import (
    ERRORS,
    LARGEST_EFFORTS,
    LEG_S,
    PARTS,
    errors,
    mean_checks,
    nees_of,
    start_navigation,
)
from uwsim.scenario import Scenario, load
from uwsim.scenario.read.assets import assets_folder
from uwsim.simulator.onboard_navigation import ALIGNMENT_STD_M, ALIGNMENT_STD_M_S
from uwsim.simulator.simulator import Simulator

Array = NDArray[np.float64]
Counts = dict[str, tuple[int, int]]  # Navigator.counts
SEAS: dict[str, dict[str, Any]] = {
    "still water": {"kind": "still"},
    "Airy waves of 0.1 m, 5 s": {"kind": "airy", "amplitude_m": 0.1, "period_s": 5.0},
    "Airy waves of 0.25 m, 5 s": {"kind": "airy", "amplitude_m": 0.25, "period_s": 5.0},
    "a sea of 0.5 m, 5 s": {"kind": "jonswap", "significant_height_m": 0.5, "peak_period_s": 5.0},
}
VEHICLES = (
    "bluerov2_heavy", "bluerov2_heavy_cfd", "bluerov2_heavy_outfit", "bluerov2_tank", "bluerov2_wu", "lauv", "remus100",
    "rov",
)  # fmt: skip
START_WORLD_M = (0.0, 0.0, -3.0)
LEGS, LEGS_PER_LOOK = 20, 2
MOST_M_S, MOST_M = 0.1, 0.2
"""The largest errors of velocity, and of 95 % of positions: a flight starts with ALIGNMENT_STD_M on each axis."""
MOST_BY_WAVES_M = 0.05
"""How much larger the largest error of position may be in waves than in still water, where the same seeds fly."""


def sea(surface: dict[str, Any], model: str) -> Scenario:
    """Return the lagoon with this surface and a neutrally buoyant vehicle, 3 m deep."""
    lagoon = load("lagoon")
    plain = {key: getattr(lagoon, key) for key in type(lagoon).model_fields}
    plain["water"] = {**lagoon.water.model_dump(), "surface": surface}
    start = {"position_m": list(START_WORLD_M)}
    plain["vehicles"] = [{"name": "rov", "model": model, "trim": {"net_buoyancy_n": 0.0}, "start": start}]
    return Scenario.model_validate(plain, context={"folder": assets_folder() / "scenarios"})


def wave_flight(
    sim: Simulator, seed: int, start_world_m: tuple[float, float, float] = START_WORLD_M
) -> Iterator[tuple[Array, list[float], Counts]]:
    """Fly with random efforts; at intervals, yield the errors (9,), the NEES of all and each of PARTS, and counts."""
    navigator, draws = start_navigation(
        sim, seed, start_world_m, position_std_m=ALIGNMENT_STD_M, velocity_std_m_s=ALIGNMENT_STD_M_S
    )
    driven = np.array([axis in sim.rov.controllable for axis in AXES])
    for leg in range(LEGS):
        sim.rov.set_effort(*(LARGEST_EFFORTS * draws.uniform(-1.0, 1.0, 6) * driven))
        sim.advance(LEG_S)
        if leg % LEGS_PER_LOOK == LEGS_PER_LOOK - 1:
            error, covariance = errors(sim, navigator), navigator.covariance
            nees = [nees_of(error, covariance, part) for part in (slice(0, ERRORS), *PARTS.values())]
            yield error, nees, navigator.counts


def wave_checks(seeds: int, vehicles: tuple[str, ...] = VEHICLES) -> list[Check]:
    """Fly each of SEAS with every seed, in turn with each vehicle; return the checks of the errors and their NEES."""
    found, still = [], None
    for name, surface in SEAS.items():
        sims = [Simulator(sea(surface, model)) for model in vehicles]
        flights = [list(wave_flight(sim, seed)) for sim, seed in zip(cycle(sims), range(seeds), strict=False)]
        error = np.array([[error for error, _, _ in flight] for flight in flights])
        group = f"{seeds} flights in {name}"
        speeds, distances = (np.linalg.norm(error[:, :, PARTS[part]], axis=2) for part in ("velocity", "position"))
        found.append(at_most(group, "largest error of velocity", MOST_M_S, float(speeds.max()), "m/s"))
        found.append(at_most(group, "95 % of errors of position", MOST_M, float(np.quantile(distances, 0.95)), "m"))
        still = distances.max() if still is None else still
        by_waves = float(distances.max() - still)
        found.append(at_most(group, "largest error of position beyond still water's", MOST_BY_WAVES_M, by_waves, "m"))
        found += mean_checks(np.array([[nees for _, nees, _ in flight] for flight in flights]), f"({name})")
    return found
