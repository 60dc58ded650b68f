"""Identification: a vehicle's coefficients from a log, with intervals, and what the log does not determine."""

from uwsim.identification.motion_log import MotionLog, read_log
from uwsim.identification.solution import Identified, identify

__all__ = ["Identified", "MotionLog", "identify", "read_log"]
