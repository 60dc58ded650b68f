"""Validation: comparisons of the simulator with closed forms and published data, as tables and curves.

A suite is a module with `run(out) -> list[Check]` and a line in SUITES.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

from uwsim.validate.check import Check

SUITES = {
    "dynamics": "uwsim.validate.dynamics",
    "sonar": "uwsim.validate.sonar",
    "imaging": "uwsim.validate.imaging",
    "camera": "uwsim.validate.camera",
    "link": "uwsim.validate.link",
    "control": "uwsim.validate.control",
    "estimation": "uwsim.validate.estimation",
}


def run_suite(name: str, out: Path | None = None) -> list[Check]:
    """Return all checks of one suite; draw its curves into the folder `out`. Raises ValueError for an unknown name."""
    if name not in SUITES:
        raise ValueError(f"validation '{name}': unknown; there are: {', '.join(SUITES)}")
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
    checks: list[Check] = import_module(SUITES[name]).run(out)
    return checks
