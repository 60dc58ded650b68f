"""The simulator's own actions, as providers in the graph."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from uwsim.bridges.actions import SUCCEEDED, Goal, JointGoal, Offered, accepted
from uwsim.bridges.rosbridge.graph import ActionGoal
from uwsim.channels.ros.message_in import from_plain
from uwsim.channels.ros.message_out import to_plain
from uwsim.live import LiveSimulator


class OwnAction:
    """An ActionHandler. post: calls a function, with arguments, on the graph's thread."""

    def __init__(self, live: LiveSimulator, action: Offered, post: Callable[..., object]) -> None:
        self._live, self._action, self._post = live, action, post
        self._goals: dict[ActionGoal, Goal | JointGoal] = {}

    def begin(self, goal: ActionGoal, arguments: Any) -> None:
        """Begin a flight. Raises ValueError if the goal is impossible or the vehicle cannot be commanded now."""
        message = from_plain(f"{self._action.type}_Goal", arguments, "args")
        flight = accepted(self._live, self._action, message, partial(self._fed, goal), partial(self._ended, goal))
        self._goals[goal] = flight
        flight.start()

    def cancel(self, goal: ActionGoal) -> None:
        """Cancel a flight."""
        if goal in self._goals:
            self._goals[goal].cancel()

    def close(self) -> None:
        """Abort all flights."""
        for flight in list(self._goals.values()):
            flight.close()

    def _fed(self, goal: ActionGoal, feedback: Any) -> None:
        self._post(goal.feed_back, to_plain(feedback))

    def _ended(self, goal: ActionGoal, status: int, result: Any) -> None:
        self._post(self._finish, goal, status, to_plain(result))

    def _finish(self, goal: ActionGoal, status: int, result: Any) -> None:
        del self._goals[goal]
        goal.finish(status == SUCCEEDED, status, result)
