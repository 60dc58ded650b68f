"""The simulator's parameters as topics of ROS 2: /parameter_events, and /set_parameter for peers without services."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from uwsim.bridges.ros2.rosout import INFO, WARN
from uwsim.bridges.ros2.service_topics import Report
from uwsim.channels import Channel
from uwsim.channels.calls.parameter_table import ParameterTable
from uwsim.channels.calls.rcl_parameters import plain_value, value_of
from uwsim.channels.ros import build
from uwsim.channels.ros.messages import from_plain
from uwsim.live import LiveSimulator

EVENTS, EVENTS_TOPIC = "rcl_interfaces/msg/ParameterEvent", "parameter_events"
EVENTS_DEPTH = 1000  # as in rclcpp
NAME, TYPE = "set_parameter", "rcl_interfaces/msg/Parameter"


class ParameterEvents:
    """Publishes the changes of a live simulator's parameters. node: the node's name, with its slash."""

    def __init__(self, live: LiveSimulator, node: str, publish: Callable[[Any], object]) -> None:
        self._live, self._node, self._publish = live, node, publish
        self._table = ParameterTable(live)
        self._set: dict[str, Any] = self._table.own.changes
        self.close = self._table.close
        self._table.listen(self._changed)

    def _changed(self, command: str, arguments: dict[str, Any]) -> None:
        """Publish the values that a command has changed, on the simulator's thread."""
        before, self._set = self._set, self._table.own.changes
        names = {name for name in before.keys() | self._set.keys() if before.get(name) != self._set.get(name)}
        names |= arguments.get("changes", {}).keys()
        if command == "set_lamp":
            names.add(f"{arguments['vehicle']}.lamps.{arguments['lamp']}.on")
        found = self._table.values(sorted(names)) if names else {}
        if found:
            changed = [{"name": name, "value": plain_value(value)} for name, value in found.items()]
            message = from_plain(EVENTS, {"node": self._node, "changed_parameters": changed})
            message.stamp = build.time(self._live.simulator.time_ns)
            self._publish(message)


def parameter_channel(report: Report) -> Channel:
    """Return the channel that sets parameters. report: reports whether a parameter was set."""

    def apply(live: LiveSimulator, message: Any) -> None:
        value = value_of(message.value)
        ParameterTable(live).set({message.name: value}).add_done_callback(
            lambda done: answer(message.name, value, done)
        )

    def answer(name: str, value: Any, done: Future[Any]) -> None:
        error = None if done.cancelled() else done.exception()
        report(WARN if error else INFO, f"/{NAME}: {error}" if error else f"/{NAME}: {name} = {value}")

    return Channel(NAME, TYPE, "in", "set a parameter of the simulation, such as rov.drag.linear.surge", apply=apply)
