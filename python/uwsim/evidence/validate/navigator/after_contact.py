"""Checks navigation after contacts: soon after the vehicle is free, the filter's errors match its covariance.

A collision exceeds the accelerometer's range, and a hull that overlaps the ground is moved and rotated by the
contact solver without any instrument measuring it. The measure is the NEES of estimation.py, RECOVERY_S after the
vehicle lifts off.
"""

from __future__ import annotations

import numpy as np
from scipy.stats import chi2

from uwsim.evidence.validate.check import Check, at_most
from uwsim.evidence.validate.navigator.consistency import ERRORS, errors, nees_of, start_navigation
from uwsim.simulator.simulator import Simulator

PLACE_WORLD_M = (-30.0, -40.0)
CONTACTS = {  # height of the hull's centre above the bed, where the hull is 0.6 m high; velocity [m/s]
    "thrown onto the bed at 2 m/s": (1.0, (0.0, 0.0, -2.0)),
    "skidding on the bed from 1.8 m/s": (0.6, (1.5, 0.0, -1.0)),
    "placed halfway in the bed": (0.05, (0.0, 0.0, 0.0)),
}
BEYOND = {"placed halfway in the bed": 2.0}  # factors on the bound: unmeasured motion is not fully recovered
PRESSED_S, LIFTED_S, RECOVERY_S = 5.0, 10.0, 20.0
PRESSING, LIFTING = (0.6, 0.0, -0.5, 0.0, 0.0, 0.2), (-0.2, 0.0, 0.5, 0.0, 0.0, 0.0)


def after_contact(sim: Simulator, seed: int, height_m: float, velocity_m_s: tuple[float, float, float]) -> float:
    """Let the vehicle touch the bed and lift off; return the NEES RECOVERY_S after lift-off."""
    bed_m = float(sim.world.height_at(np.array([PLACE_WORLD_M]))[0])
    navigator, _ = start_navigation(sim, seed, (*PLACE_WORLD_M, bed_m + height_m), velocity_m_s)
    sim.rov.set_effort(*PRESSING)
    sim.advance(PRESSED_S)
    assert sim.rov.collisions > 0
    sim.rov.set_effort(*LIFTING)
    sim.advance(LIFTED_S)
    sim.rov.set_effort()
    sim.advance(RECOVERY_S - LIFTED_S)
    return nees_of(errors(sim, navigator), navigator.covariance, slice(0, ERRORS))


def contact_checks(sim: Simulator, seeds: int) -> list[Check]:
    """Fly each contact with every seed; compare the mean NEES with BEYOND (default 1) times its upper 97.5 % bound."""
    most = float(chi2.ppf(0.975, seeds * ERRORS) / seeds)
    return [
        at_most(
            f"{seeds} flights {how}",
            f"mean NEES {RECOVERY_S:.0f} s after it lifts off",
            BEYOND.get(how, 1.0) * most,
            float(np.mean([after_contact(sim, seed, *contact) for seed in range(seeds)])),
        )
        for how, contact in CONTACTS.items()
    ]
