"""Checks the navigation of a vehicle that turns about all axes: the filter's errors match its covariance.

An uncontrolled BlueROV2 hardly rights itself, so small torques make it roll, pitch and tumble, even upside down. Its
DVL then loses the bottom, while the depth sensor, compass, USBL and IMU continue to measure; a second flight has no DVL
at all, and turns faster, so that the compass passes the vertical while the attitude is hardly known. The measure is the
NEES of estimation.py.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from uwsim.evidence.validate.check import Check
from uwsim.evidence.validate.navigator.consistency import (
    ERRORS,
    PARTS,
    consistency_checks,
    errors,
    nees_of,
    start_navigation,
)
from uwsim.scenario import Scenario, load
from uwsim.scenario.read.assets import assets_folder
from uwsim.simulator.simulator import Simulator

TURNS = {  # smallest and largest shares of the full torque about each body axis, in either direction
    "rolling": ((0.03, 0.0, 0.0), (0.12, 0.01, 0.05)),
    "pitching": ((0.0, 0.03, 0.0), (0.01, 0.12, 0.05)),
    "tumbling": ((0.02, 0.02, 0.02), (0.08, 0.08, 0.1)),
}
FASTER = 2.5  # times the torque, without the DVL
PUSH = np.array([0.3, 0.3, 0.15])  # largest shares of the full forces
LEGS, LEG_S, LEGS_PER_LOOK = 16, 2.5, 2


def turning_vehicle() -> Scenario:
    """Return the lake scenario with a free BlueROV2 trimmed to neutral buoyancy."""
    lake = load("lake")
    plain = {key: getattr(lake, key) for key in type(lake).model_fields}
    vehicle = {
        "name": "rov",
        "model": "bluerov2_heavy",
        "trim": {"net_buoyancy_n": 0.0},
        "start": {"position_m": [-30, -40, -12]},
    }
    return Scenario.model_validate({**plain, "vehicles": [vehicle]}, context={"folder": assets_folder() / "scenarios"})


def turning_flight(sim: Simulator, seed: int, turn: str, *, dvl: bool = True) -> Iterator[list[float]]:
    """Fly with random efforts while turning; at intervals, yield the NEES of all errors and of each of PARTS.

    Without the DVL, the vehicle turns FASTER.
    """
    navigator, draws = start_navigation(sim, seed)
    sim.parameters["rov.sensors.dvl.on"] = dvl
    least, most = np.array(TURNS[turn]) * (1.0 if dvl else FASTER)
    side = np.where(draws.random(3) < 0.5, -1.0, 1.0)
    for leg in range(LEGS):
        torque = side * draws.uniform(least, most)
        sim.rov.set_effort(*(PUSH * draws.uniform(-1.0, 1.0, 3)), *torque)
        sim.advance(LEG_S)
        if leg % LEGS_PER_LOOK == LEGS_PER_LOOK - 1:
            error, covariance = errors(sim, navigator), navigator.covariance
            yield [nees_of(error, covariance, part) for part in (slice(0, ERRORS), *PARTS.values())]


def turning_checks(seeds: int) -> list[Check]:
    """Fly each of TURNS with every seed, with and without the DVL; return the NEES checks."""
    sim, found = Simulator(turning_vehicle()), []
    for turn in TURNS:
        for dvl in (True, False):
            nees = np.array([list(turning_flight(sim, seed, turn, dvl=dvl)) for seed in range(seeds)])
            found += consistency_checks(nees, turn if dvl else f"{turn}, without DVL,", LEG_S * LEGS_PER_LOOK)
    return found
