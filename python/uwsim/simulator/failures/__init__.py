"""Failures and the reactions to them: faults, a vehicle's alarms and its failsafe."""

from typing import TYPE_CHECKING

from uwsim.base.lazy import lazy

if TYPE_CHECKING:
    from uwsim.simulator.failures.events import Event, EventLog
    from uwsim.simulator.failures.failsafe import Failsafe
    from uwsim.simulator.failures.faults import Faults
    from uwsim.simulator.failures.reactions import Reactions

__all__ = ["Event", "EventLog", "Failsafe", "Faults", "Reactions"]
__getattr__ = lazy(
    __name__,
    {"Reactions": "reactions", "Event": "events", "EventLog": "events", "Failsafe": "failsafe", "Faults": "faults"},
)
