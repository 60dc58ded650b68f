"""MAVLink: a simulated vehicle speaks MAVLink 2 as ArduSub does, for ground stations and scripts."""

from uwsim.bridges.mavlink.endpoint import Endpoint
from uwsim.bridges.mavlink.vehicle import MavlinkVehicle

__all__ = ["Endpoint", "MavlinkVehicle"]
