"""Failures and the reactions to them: faults, a vehicle's alarms and its failsafe."""

from uwsim.simulator.failures.aboard import Aboard
from uwsim.simulator.failures.events import Event, EventLog
from uwsim.simulator.failures.failsafe import Failsafe
from uwsim.simulator.failures.faults import Faults

__all__ = ["Aboard", "Event", "EventLog", "Failsafe", "Faults"]
