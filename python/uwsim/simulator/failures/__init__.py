"""Failures and reactions to them: faults that occur, alarms that a vehicle raises, its failsafe."""

from uwsim.simulator.failures.aboard import Aboard
from uwsim.simulator.failures.events import Event, EventLog
from uwsim.simulator.failures.failsafe import Failsafe
from uwsim.simulator.failures.faults import Faults

__all__ = ["Aboard", "Event", "EventLog", "Failsafe", "Faults"]
