"""Control of vehicles through their public interface only, so that simulated and remote vehicles work alike."""

from uwsim.navigation.control.autopilot import Autopilot
from uwsim.navigation.control.controller import Controller
from uwsim.navigation.control.path import PathFollower
from uwsim.navigation.control.protocols import Clock, EstimateLike, SteeredVehicle, Watch

__all__ = ["Autopilot", "Clock", "Controller", "EstimateLike", "PathFollower", "SteeredVehicle", "Watch"]
