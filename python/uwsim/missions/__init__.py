"""Missions: Python that flies a vehicle. Copy one and change it."""

from uwsim.missions.lanes import Lane, lawn_mower_lanes
from uwsim.missions.lawn_mower import COVERED, AdaptiveLawnMower, LawnMowerPlan
from uwsim.missions.lookout import Lookout
from uwsim.missions.mission import Mission, ResumableMission

__all__ = [
    "COVERED",
    "AdaptiveLawnMower",
    "Lane",
    "LawnMowerPlan",
    "Lookout",
    "Mission",
    "ResumableMission",
    "lawn_mower_lanes",
]
