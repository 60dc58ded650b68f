"""Arrivals of sound against those that BELLHOP computed, which are kept beside the suite sound.

Recipe: the executable of aubellhop 0.2.1, run on the kept profiles and ends in the mode of arrivals; see
tests/python/data/README.md.
"""

from __future__ import annotations

from uwsim.evidence.validate.check import Check
from uwsim.evidence.validate.sound import bellhop_checks


def checks() -> list[Check]:
    """Return the checks of all kept cases."""
    return bellhop_checks()
