"""Actions: flights of a vehicle that a peer starts, follows and cancels."""

from uwsim.bridges.actions.action import Action, actions_in
from uwsim.bridges.actions.goal import ABORTED, ACCEPTED, CANCELED, CANCELING, EXECUTING, SUCCEEDED, Goal
from uwsim.bridges.actions.table import actions_of

__all__ = [
    "ABORTED",
    "ACCEPTED",
    "CANCELED",
    "CANCELING",
    "EXECUTING",
    "SUCCEEDED",
    "Action",
    "Goal",
    "actions_in",
    "actions_of",
]
