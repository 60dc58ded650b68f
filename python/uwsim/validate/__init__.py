"""Validation as a shipped tool: closed forms and published data against the code that runs, as tables and curves.

A suite is one module with `run(out) -> list[Check]`, and one line in SUITES.
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
}


def run_suite(name: str, out: Path | None = None) -> list[Check]:
    """All checks of one suite; its curves go into the folder `out`. Raises ValueError for an unknown name."""
    if name not in SUITES:
        raise ValueError(f"validation '{name}': unknown; there are: {', '.join(SUITES)}")
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
    checks: list[Check] = import_module(SUITES[name]).run(out)
    return checks
