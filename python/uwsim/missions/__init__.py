"""Missions: Python that flies a vehicle. Copy one and change it."""

from uwsim.missions.lawn_mower import AdaptiveLawnMower, LawnMowerPlan

__all__ = ["AdaptiveLawnMower", "LawnMowerPlan"]
