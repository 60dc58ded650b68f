"""Holds: a vehicle keeps heading, depth, altitude, position or speed with its own instruments while a pilot steers."""

from uwsim.simulator.holds.holds import Holds
from uwsim.simulator.holds.listener import HoldsState

__all__ = ["Holds", "HoldsState"]
