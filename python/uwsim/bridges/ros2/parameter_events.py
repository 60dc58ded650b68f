"""The topic /parameter_events, which reports each change of the simulator's parameters."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from uwsim.bridges.live_parameters import Parameters
from uwsim.channels.calls.rcl_parameters import plain_value
from uwsim.channels.ros import build
from uwsim.channels.ros.messages import from_plain
from uwsim.live import LiveSimulator

EVENTS, EVENTS_TOPIC = "rcl_interfaces/msg/ParameterEvent", "parameter_events"
EVENTS_DEPTH = 1000  # as in rclcpp


class ParameterEvents:
    """Publishes the changes of a live simulator's parameters. node: the node's name, with its slash."""

    def __init__(self, live: LiveSimulator, node: str, publish: Callable[[Any], object]) -> None:
        self._live, self._node, self._publish = live, node, publish
        self._parameters = Parameters(live, self._changed)
        self._set: dict[str, Any] = live.simulator.parameters.changes
        self.open, self.close = self._parameters.open, self._parameters.close

    def _changed(self, command: str, arguments: dict[str, Any]) -> None:
        """Publish the values that a command has changed, on the simulator's thread."""
        own = self._live.simulator.parameters
        before, self._set = self._set, own.changes
        names = {name for name in before.keys() | self._set.keys() if before.get(name) != self._set.get(name)}
        names |= arguments.get("changes", {}).keys()
        if command == "set_lamp":
            names.add(f"{arguments['vehicle']}.lamps.{arguments['lamp']}.on")
        found = [{"name": name, "value": plain_value(own[name])} for name in sorted(names) if name in own]
        if found:
            message = from_plain(EVENTS, {"node": self._node, "changed_parameters": found})
            message.stamp = build.time(self._live.simulator.time_ns)
            self._publish(message)
