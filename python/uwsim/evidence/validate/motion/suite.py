"""The dynamics suite: bodies with a closed form, thrusters, fins, and the published vehicles."""

from __future__ import annotations

from uwsim.evidence.validate.check import Check
from uwsim.evidence.validate.motion.closed_forms import closed_forms
from uwsim.evidence.validate.motion.fins import fin_checks
from uwsim.evidence.validate.motion.published import PUBLISHED
from uwsim.evidence.validate.motion.thrusters import thruster_checks
from uwsim.evidence.validate.motion.vehicles import vehicle_checks
from uwsim.scenario import load_vehicle


def run() -> list[Check]:
    """Return the checks of the suite."""
    vehicles = [check for name in PUBLISHED for check in vehicle_checks(name, load_vehicle(name))]
    return [*closed_forms(), *thruster_checks(), *fin_checks(), *vehicles]
