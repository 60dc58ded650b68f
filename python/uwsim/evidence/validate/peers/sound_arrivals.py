"""Compares sound arrivals with BELLHOP's, which are stored beside the sound suite.

The executable of aubellhop 0.2.1 computed them from the stored profiles and end points in its arrivals mode; see
tests/python/data/README.md.
"""

from __future__ import annotations

from uwsim.evidence.validate.check import Check
from uwsim.evidence.validate.sound import bellhop_checks


def checks() -> list[Check]:
    """Return the checks of all stored cases."""
    return bellhop_checks()
