"""Connects a simulated vehicle to ground stations and scripts through MAVLink 2, as ArduSub does."""

from typing import TYPE_CHECKING

from uwsim.base.lazy import lazy

if TYPE_CHECKING:
    from uwsim.bridges.mavlink.vehicle import MavlinkVehicle

__all__ = ["MavlinkVehicle"]
__getattr__ = lazy(__name__, {"MavlinkVehicle": "vehicle"})
