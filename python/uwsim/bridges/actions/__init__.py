"""Actions: flights of a vehicle, and motions of its arm, that a peer starts, follows and cancels."""

from uwsim.bridges.actions.action import Action, Offered, actions_in
from uwsim.bridges.actions.goal import ABORTED, ACCEPTED, CANCELED, CANCELING, EXECUTING, SUCCEEDED, Goal, accepted
from uwsim.bridges.actions.joints import JointAction, JointGoal
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
    "JointAction",
    "JointGoal",
    "Offered",
    "accepted",
    "actions_in",
    "actions_of",
]
