"""Control of a vehicle through its public names only, so that the same code controls a simulated or a remote one."""

from uwsim.navigation.control.autopilot import Autopilot
from uwsim.navigation.control.controller import Controller
from uwsim.navigation.control.path import PathFollower
from uwsim.navigation.control.protocols import Clock, EstimateLike, SteeredVehicle, Watch

__all__ = ["Autopilot", "Clock", "Controller", "EstimateLike", "PathFollower", "SteeredVehicle", "Watch"]
