"""The dynamics suite: closed forms, contact, thrusters, fins, and the published vehicles."""

from __future__ import annotations

from pathlib import Path

from uwsim.evidence.validate.check import Check
from uwsim.evidence.validate.closed_forms import closed_forms
from uwsim.evidence.validate.contact import contact_laws
from uwsim.evidence.validate.fins import fin_checks
from uwsim.evidence.validate.published import PUBLISHED
from uwsim.evidence.validate.thrusters import thruster_checks
from uwsim.evidence.validate.vehicle_curves import draw_decays, draw_turning
from uwsim.evidence.validate.vehicles import vehicle_checks


def run(out: Path | None = None) -> list[Check]:
    """Return the checks of the suite; draw each vehicle's decay and turning curves into the folder `out`."""
    checks = [*closed_forms(), *contact_laws(), *thruster_checks(), *fin_checks()]
    for name in PUBLISHED:
        found, curves = vehicle_checks(name)
        checks += found
        if out is not None:
            draw_decays(curves, out / f"{name}_decay.png")
            draw_turning(curves[-1], out / f"{name}_turning.png")
    return checks
