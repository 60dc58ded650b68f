"""A vehicle behind a rosbridge, with the names that missions use: one simulated by `uwsim serve`, or a real one."""

from uwsim.bridges.remote.clock import LockstepClock, RemoteClock
from uwsim.bridges.remote.connection import RemoteConnection
from uwsim.bridges.remote.vehicle import RemoteVehicle, vehicle_names

__all__ = ["LockstepClock", "RemoteClock", "RemoteConnection", "RemoteVehicle", "vehicle_names"]
