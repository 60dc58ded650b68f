"""Connects a simulated vehicle to ground stations and scripts through MAVLink 2, as ArduSub does."""

from uwsim.bridges.mavlink.endpoint import Endpoint
from uwsim.bridges.mavlink.vehicle import MavlinkVehicle

__all__ = ["Endpoint", "MavlinkVehicle"]
