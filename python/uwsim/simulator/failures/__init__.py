"""Failures and what a vehicle does about them: faults that happen, alarms that it notices, its failsafe."""

from uwsim.simulator.failures.aboard import Aboard
from uwsim.simulator.failures.events import Event, EventLog
from uwsim.simulator.failures.failsafe import Failsafe
from uwsim.simulator.failures.faults import Faults

__all__ = ["Aboard", "Event", "EventLog", "Failsafe", "Faults"]
