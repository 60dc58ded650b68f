"""A simulator paced by the wall clock. One thread steps it, and commands from any thread are logged by tick."""

from uwsim.base.commands import COMMANDS
from uwsim.live.clock import LiveClock, MissionClock
from uwsim.live.command_log import CommandLog, Entry, replay
from uwsim.live.live_simulator import ACTS, PACE_ACTS, LiveSimulator
from uwsim.live.requests import NotRunningError, Subscription
from uwsim.live.vehicle import LiveVehicle

__all__ = [
    "ACTS",
    "COMMANDS",
    "PACE_ACTS",
    "CommandLog",
    "Entry",
    "LiveClock",
    "LiveSimulator",
    "LiveVehicle",
    "MissionClock",
    "NotRunningError",
    "Subscription",
    "replay",
]
