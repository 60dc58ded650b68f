"""Missions: Python programs that fly a vehicle. Copy one and change it."""

from uwsim.missions.lanes import Lane, lawn_mower_lanes
from uwsim.missions.lawn_mower import COVERED, AdaptiveLawnMower
from uwsim.missions.lawn_mower_plan import LawnMowerPlan
from uwsim.missions.mission import Mission, ResumableMission
from uwsim.missions.obstacle_memory import ObstacleMemory

__all__ = [
    "COVERED",
    "AdaptiveLawnMower",
    "Lane",
    "LawnMowerPlan",
    "Mission",
    "ObstacleMemory",
    "ResumableMission",
    "lawn_mower_lanes",
]
