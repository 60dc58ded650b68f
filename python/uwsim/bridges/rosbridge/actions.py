"""A client's goals for actions of the simulator or other clients, and others' goals for the client's own actions.

This implements the action operations of version 2.1 of the protocol. For the simulator's actions, see `own_actions`.
"""

from __future__ import annotations

import itertools
from typing import Any

from uwsim.bridges.rosbridge.calls import CALL_BYTES, echoed
from uwsim.bridges.rosbridge.encoding import to_json
from uwsim.bridges.rosbridge.fragments import read_fragment_size
from uwsim.bridges.rosbridge.graph import ActionGoal, Graph, plain_name
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.bridges.rosbridge.names import Names
from uwsim.bridges.rosbridge.outbox import Outbox
from uwsim.channels.ros.message_types import shortened

SUCCEEDED, ABORTED = 4, 6  # action_msgs/msg/GoalStatus
STATUSES = range(7)


class Goal:
    """A goal sent by a client. head: the fields common to its feedback and its result."""

    def __init__(self, actions: Actions, head: dict[str, Any], size: int, operation: dict[str, Any]) -> None:
        self.actions: Actions | None = actions
        self.head, self.size = head, size
        self.fragment_size = read_fragment_size(operation)
        self._wants_feedback = operation.get("feedback") is True

    def feed_back(self, values: Any) -> None:
        """Send feedback, if the client asked for it."""
        if self.actions is not None and self._wants_feedback:
            self.actions.send({"op": "action_feedback", **self.head, "values": values}, self.fragment_size)

    def finish(self, succeeded: bool, status: int, values: Any) -> None:
        """Send the result if the client is still connected. A second result is ignored."""
        actions, self.actions = self.actions, None
        if actions is not None:
            actions.forget(self)
            result = {"values": values, "status": status, "result": succeeded}
            actions.send({"op": "action_result", **self.head, **result}, self.fragment_size)


class Actions:
    """A client's goals in both directions. name: the client's name in the graph.

    spent_bytes: the memory that the current operation takes, which may be kept until the result.
    """

    def __init__(self, graph: Graph, name: str, names: Names, limits: Limits, outbox: Outbox) -> None:
        self._graph, self._name, self._names = graph, name, names
        self._limits, self._outbox = limits, outbox
        self.spent_bytes = 0
        self._sent: dict[tuple[str, Any], Goal] = {}  # by action and the client's ID
        self._received: dict[str, tuple[str, str, ActionGoal]] = {}  # name as sent, plain name and goal, by our id
        self._numbers = itertools.count(1)

    # Goals of this client

    def send_goal(self, operation: dict[str, Any]) -> None:
        """Send a goal to the action's provider. If there is none, the result is a failure with the reason."""
        name, identity = operation.get("action"), operation.get("id")
        head = {"action": echoed(name)} | ({} if identity is None else {"id": identity})
        key = (plain_name(name, "action"), identity)
        if key in self._sent:
            raise ValueError(f"action '{name}': your goal with id {shortened(identity)} is still in progress")
        if len(self._sent) >= self._limits.open_calls:
            raise ValueError(f"{self._limits.open_calls} of your goals are in progress, the maximum")
        size = CALL_BYTES + self.spent_bytes
        if not self._outbox.kept.has(size):
            raise ValueError("no room to keep the goal: too much waits for you")
        goal = Goal(self, head, size, operation)
        self._outbox.kept.take(size)
        self._sent[key] = goal
        action = self._graph.actions.get(key[0])
        try:
            if action is None:
                raise ValueError(f"action '{name}': no client offers it")
            kind = operation.get("action_type") or action.type
            if kind != action.type:
                raise ValueError(f"action '{name}': is {action.type}, not {shortened(kind)}")
            action.handler.begin(goal, operation.get("args") or {})
        except ValueError as error:
            goal.finish(False, ABORTED, str(error))

    def cancel_goal(self, operation: dict[str, Any]) -> None:
        """Forward a request to cancel a goal. The provider answers with the goal's result."""
        name, identity = plain_name(operation.get("action"), "action"), operation.get("id")
        goal, action = self._sent.get((name, identity)), self._graph.actions.get(name)
        if goal is None or action is None:
            raise ValueError(f"action '{name}': you have no goal in progress with id {shortened(identity)}")
        action.handler.cancel(goal)

    def forget(self, goal: Goal) -> None:
        """Remove a finished goal."""
        self._sent = {key: kept for key, kept in self._sent.items() if kept is not goal}
        self._outbox.kept.give(goal.size)

    def send(self, operation: dict[str, Any], fragment_size: int | None = None) -> None:
        """Send an operation to the client."""
        try:
            frame = to_json(operation)
        except ValueError as error:
            frame = to_json(operation | {"values": f"values: {error}"})
        self._outbox.reply(frame, fragment_size)

    # Actions that this client offers

    def advertise(self, operation: dict[str, Any]) -> None:
        """Register an action that the client offers."""
        name, type_name = operation.get("action"), operation.get("type", "")
        plain = plain_name(name, "action")
        if not isinstance(type_name, str) or len(type_name) > 200:
            raise ValueError(f"type = {shortened(type_name)}: must be the name of an action's type")
        self._names.check_room()
        self._graph.advertise_action(self._name, plain, type_name, self)
        self._names.actions[plain] = str(name)

    def unadvertise(self, operation: dict[str, Any]) -> None:
        """Remove an action that the client offers, and abort the goals in progress."""
        plain = plain_name(operation.get("action"), "action")
        self._graph.unadvertise_action(self._name, plain)
        self._names.actions.pop(plain, None)
        self._abort(plain, f"{self._name} has ceased to offer it")

    def begin(self, goal: ActionGoal, arguments: Any) -> None:
        """Pass a goal to the client. Raises ValueError if too many are in progress."""
        assert isinstance(goal, Goal)
        plain = plain_name(goal.head["action"], "action")
        if len(self._received) >= self._limits.open_calls:
            raise ValueError(f"action '{plain}': {self._limits.open_calls} goals are in progress, the maximum")
        action, kind = self._names.actions[plain], self._graph.actions[plain].type
        identity = f"action_goal:{action}:{next(self._numbers)}"
        self._received[identity] = action, plain, goal
        self._outbox.kept.take(CALL_BYTES)
        sent = {"action": action, "action_type": kind, "args": arguments, "feedback": True}
        self.send({"op": "send_action_goal", "id": identity, **sent})

    def cancel(self, goal: ActionGoal) -> None:
        """Ask the client to cancel a goal."""
        for identity, (action, _, kept) in self._received.items():
            if kept is goal:
                self.send({"op": "cancel_action_goal", "id": identity, "action": action})

    def feed_back(self, operation: dict[str, Any]) -> None:
        """Forward the client's feedback. Raises ValueError if there is no such goal."""
        self._goal(operation)[2].feed_back(operation.get("values", {}))

    def finish(self, operation: dict[str, Any]) -> None:
        """Forward the client's result. Raises ValueError for an unknown goal or an invalid status."""
        goal = self._goal(operation)[2]
        succeeded = operation.get("result", True) is not False
        status = operation.get("status", SUCCEEDED if succeeded else ABORTED)
        if type(status) is not int or status not in STATUSES:
            raise ValueError(f"action_result.status = {shortened(status)}: must be in [0, 6]")
        del self._received[operation["id"]]
        self._outbox.kept.give(CALL_BYTES)
        goal.finish(succeeded, status, operation.get("values", {}))

    def close(self) -> None:
        """Called when the client has left: abort the goals that it was executing, and cancel those that it sent."""
        self._abort(None, f"{self._name}, who offers it, has left")
        for (name, _), goal in list(self._sent.items()):
            goal.actions = None
            action = self._graph.actions.get(name)
            if action is not None:
                action.handler.cancel(goal)
        self._sent.clear()

    def _goal(self, operation: dict[str, Any]) -> tuple[str, str, ActionGoal]:
        identity = operation.get("id")
        found = self._received.get(identity) if isinstance(identity, str) else None
        if found is None:
            raise ValueError(f"{operation['op']}.id = {shortened(identity)}: no such goal is in progress")
        return found

    def _abort(self, plain: str | None, reason: str) -> None:
        """Abort the goals in progress of one action, or of all actions."""
        for identity, (_, name, goal) in list(self._received.items()):
            if plain in (None, name):
                del self._received[identity]
                self._outbox.kept.give(CALL_BYTES)
                goal.finish(False, ABORTED, f"action '{name}': {reason}")
