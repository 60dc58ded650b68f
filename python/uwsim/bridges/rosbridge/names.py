"""The names of the topics, services and actions that a client uses, whose number is limited."""

from __future__ import annotations

from uwsim.bridges.rosbridge.graph import Graph
from uwsim.bridges.rosbridge.limits import Limits
from uwsim.bridges.rosbridge.subscription import Subscription


class Names:
    """A client's names.

    advertised: whether each advertised topic is latched, keyed by its name without a slash. subscriptions: keyed by the
    name as sent. actions: the names as sent, keyed by the name without a slash.
    """

    def __init__(self, graph: Graph, limits: Limits) -> None:
        self._graph = graph
        self._limits = limits
        self.advertised: dict[str, bool] = {}
        self.subscriptions: dict[str, Subscription] = {}
        self.services: set[str] = set()
        self.actions: dict[str, str] = {}

    def check_room(self) -> None:
        """Raise ValueError if this client, or all clients together, may not use any more names."""
        own = len(self.advertised) + len(self.subscriptions) + len(self.services) + len(self.actions)
        if own >= self._limits.names:
            raise ValueError(f"names: you have {self._limits.names} topics, services and actions, the maximum")
        if len(self._graph.topics) + len(self._graph.services) + len(self._graph.actions) >= self._limits.all_names:
            raise ValueError(f"names: there are {self._limits.all_names} topics, services and actions, the maximum")
