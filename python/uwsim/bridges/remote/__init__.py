"""A real or simulated vehicle behind a rosbridge server, with the interface that missions use."""

from uwsim.bridges.remote.clock import LockstepClock, RemoteClock
from uwsim.bridges.remote.connection import RemoteConnection
from uwsim.bridges.remote.vehicle import RemoteVehicle, vehicle_names

__all__ = ["LockstepClock", "RemoteClock", "RemoteConnection", "RemoteVehicle", "vehicle_names"]
