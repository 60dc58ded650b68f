"""Identification: a vehicle's coefficients from a log, with intervals, and what the log does not determine."""

from uwsim.identification.identify import Identified, identify
from uwsim.identification.motion_log import MotionLog, read_log

__all__ = ["Identified", "MotionLog", "identify", "read_log"]
