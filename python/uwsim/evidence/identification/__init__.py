"""Identification: estimates a vehicle's coefficients from a log, with intervals, and lists what the log leaves open."""

from uwsim.evidence.identification.solution import Identified, identify
from uwsim.exchange.logs.motion_log import read_log
from uwsim.recording.real_flights.motion import MotionLog

__all__ = ["Identified", "MotionLog", "identify", "read_log"]
