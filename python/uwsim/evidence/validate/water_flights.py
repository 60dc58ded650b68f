"""Checks navigation under water of unknown height and weight: the filter does not become sure of a wrong depth.

A depth gauge measures the weight of the water above it. Under a tide, or below a lens of fresh water, that is not the
depth below z = 0, by up to metres. The flights are those of wave_flights.py, of every packaged vehicle with a gauge,
each at another phase of the tide; the measure is the NEES of estimation.py.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import cycle
from typing import Any

import numpy as np
from scipy.stats import chi2

from uwsim.evidence.validate.check import Check, at_most
from uwsim.evidence.validate.consistency import ERRORS, PARTS
from uwsim.evidence.validate.wave_flights import wave_flight
from uwsim.scenario import Scenario
from uwsim.scenario.read.assets import assets_folder
from uwsim.simulator.simulator import Simulator

VEHICLES = (
    "bluerov2_heavy", "bluerov2_heavy_alpha5", "bluerov2_heavy_cfd", "bluerov2_heavy_gripper", "bluerov2_heavy_outfit",
    "bluerov2_tank", "bluerov2_wu", "lauv", "paper", "paper_buoyant", "remus100", "rov", "slocum",
)  # fmt: skip
LENS = ((0.0, 5.0), (10.0, 5.0), (12.0, 35.0))
"""Depths [m] and salinities [psu]."""
MOST_M = 0.35
"""The largest error of the height, of 95 % of the looks: a flight starts with ALIGNMENT_STD_M on each axis."""
MOST_REJECTED = 0.01
FALSE_ALARM = 1e-3


@dataclass(frozen=True)
class UnknownWater:
    """tide_m: amplitude of the M2 tide. levels: depths [m] and salinities [psu]."""

    depth_m: float
    tide_m: float = 0.0
    levels: tuple[tuple[float, float], ...] = ()


WATERS = {
    "a tide of 1.5 m": UnknownWater(10.0, tide_m=1.5),
    "a tide of 4 m": UnknownWater(10.0, tide_m=4.0),
    "water of 35 psu below a lens of 5": UnknownWater(50.0, levels=LENS),
    "the sea, 985 m deep": UnknownWater(985.0),
}


def scenario_in(water: UnknownWater, model: str, phase_deg: float) -> Scenario:
    """Return a bay with this water, and a neutrally buoyant vehicle at its depth, 15 m above the bed."""
    plain: dict[str, Any] = {"salinity_psu": 35}
    if water.levels:
        levels = [{"depth_m": z, "temperature_deg_c": 10, "salinity_psu": s} for z, s in water.levels]
        plain = {"profile": {"kind": "table", "levels": levels}}
    if water.tide_m:
        constituent = {"constituent": "M2", "amplitude_m": water.tide_m, "phase_deg": phase_deg}
        plain["tide"] = {"constituents": [constituent]}
    start_m = [0.0, 0.0, -water.depth_m]
    terrain = {"source": "noise", "size_m": [400, 400], "spacing_m": 10, "bed_depth_m": water.depth_m + 15}
    vehicle = {"name": "rov", "model": model, "trim": {"net_buoyancy_n": 0.0}, "start": {"position_m": start_m}}
    station = {"position_m": [30.0, 20.0, -5.0]}
    bay = {"name": "bay", "terrain": terrain, "water": plain, "station": station, "vehicles": [vehicle]}
    return Scenario.model_validate(bay, context={"folder": assets_folder() / "scenarios"})


def water_checks(seeds: int, vehicles: tuple[str, ...] = VEHICLES) -> list[Check]:
    """Fly in each of WATERS with every seed, in turn with each vehicle; return the checks."""
    found = []
    for name, water in WATERS.items():
        phases_deg = np.arange(len(vehicles)) * 360.0 / len(vehicles)
        sims = [Simulator(scenario_in(water, *each)) for each in zip(vehicles, phases_deg.tolist(), strict=True)]
        start_m = (0.0, 0.0, -water.depth_m)
        flights = [[*wave_flight(sim, seed, start_m)] for sim, seed in zip(cycle(sims), range(seeds), strict=False)]
        nees = np.array([[nees for _, nees, _ in flight] for flight in flights])
        heights_m = np.array([[abs(error[2]) for error, _, _ in flight] for flight in flights])
        used, rejected = np.sum([flight[-1][-1].get("usbl", (0, 0)) for flight in flights], axis=0)
        group = f"{seeds} flights in {name}"
        for k, (part, size) in enumerate({"all": ERRORS, **dict.fromkeys(PARTS, 3)}.items()):
            most = float(chi2.ppf(0.975, seeds * size) / seeds)
            found.append(at_most(group, f"mean NEES of {part}", most, float(nees[:, :, k].mean())))
        for vehicle, first in zip(vehicles, range(seeds), strict=False):
            mine = nees[first :: len(vehicles), :, 1]
            most = float(chi2.ppf(1.0 - FALSE_ALARM, 3 * len(mine)) / len(mine))
            found.append(at_most(group, f"mean NEES of position of {vehicle}", most, float(mine.mean())))
        found.append(at_most(group, "95 % of errors of height", MOST_M, float(np.quantile(heights_m, 0.95)), "m"))
        share = float(rejected / max(used + rejected, 1))
        found.append(at_most(group, "share of USBL fixes that the gates reject", MOST_REJECTED, share))
    return found
