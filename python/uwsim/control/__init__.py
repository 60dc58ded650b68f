"""Control of a vehicle through its public names only, so that the same code controls a simulated or a remote one."""

from uwsim.control.autopilot import Autopilot
from uwsim.control.controller import Controller
from uwsim.control.path import PathFollower
from uwsim.control.protocols import Clock, EstimateLike, SteeredVehicle, Watch

__all__ = ["Autopilot", "Clock", "Controller", "EstimateLike", "PathFollower", "SteeredVehicle", "Watch"]
