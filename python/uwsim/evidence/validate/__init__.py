"""Validation: comparisons of the simulator with closed forms and published data, as tables and curves.

A suite is a module with `run(out) -> list[Check]` and a line in SUITES.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

from uwsim.evidence.validate.check import Check

SUITES = {
    "dynamics": "uwsim.evidence.validate.dynamics",
    "sonar": "uwsim.evidence.validate.sonar",
    "imaging": "uwsim.evidence.validate.imaging",
    "camera": "uwsim.evidence.validate.camera",
    "link": "uwsim.evidence.validate.link",
    "control": "uwsim.evidence.validate.control",
    "estimation": "uwsim.evidence.validate.estimation",
}


def run_suite(name: str, out: Path | None = None) -> list[Check]:
    """Return all checks of one suite; draw its curves into the folder `out`. Raises ValueError for an unknown name."""
    if name not in SUITES:
        raise ValueError(f"validation '{name}': unknown; there are: {', '.join(SUITES)}")
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
    checks: list[Check] = import_module(SUITES[name]).run(out)
    return checks
