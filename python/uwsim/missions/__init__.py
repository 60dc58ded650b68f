"""Missions: Python programs that fly a vehicle in simulated time. See docs/guides/missions.md for how to write one."""

from uwsim.missions.heights import YoYo
from uwsim.missions.lanes import Lane, lawn_mower_lanes
from uwsim.missions.lawn_mower import COVERED, AdaptiveLawnMower, mow
from uwsim.missions.lawn_mower_plan import LawnMowerPlan
from uwsim.missions.moves import dive_to, follow, goto, hold, turn_to, visit
from uwsim.missions.own_vehicle import Event, OwnVehicle
from uwsim.missions.run import Mission, begin, run
from uwsim.missions.shoal_chart import ObstacleMemory
from uwsim.missions.steps import Steps, StoppedError, Wait, aim_to, drive, parallel, race, until, wait
from uwsim.missions.tether_home import follow_tether
from uwsim.missions.vehicle import Vehicle

__all__ = [
    "COVERED",
    "AdaptiveLawnMower",
    "Event",
    "Lane",
    "LawnMowerPlan",
    "Mission",
    "ObstacleMemory",
    "OwnVehicle",
    "Steps",
    "StoppedError",
    "Vehicle",
    "Wait",
    "YoYo",
    "aim_to",
    "begin",
    "dive_to",
    "drive",
    "follow",
    "follow_tether",
    "goto",
    "hold",
    "lawn_mower_lanes",
    "mow",
    "parallel",
    "race",
    "run",
    "turn_to",
    "until",
    "visit",
    "wait",
]
