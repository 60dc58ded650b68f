"""Failures and what a vehicle does about them: faults that happen, alarms that it notices, its failsafe."""

from uwsim.failures.aboard import Aboard
from uwsim.failures.events import Event, EventLog
from uwsim.failures.failsafe import Failsafe
from uwsim.failures.faults import Faults

__all__ = ["Aboard", "Event", "EventLog", "Failsafe", "Faults"]
