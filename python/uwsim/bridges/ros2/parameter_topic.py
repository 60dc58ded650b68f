"""The /set_parameter topic, on which peers without services set parameters with rcl_interfaces/Parameter."""

from __future__ import annotations

from concurrent.futures import Future
from typing import Any

from uwsim.bridges.ros2.rosout import INFO, WARN
from uwsim.bridges.ros2.service_topics import Report
from uwsim.channels import Channel
from uwsim.channels.calls.rcl_parameters import value_of
from uwsim.live import LiveSimulator

NAME, TYPE = "set_parameter", "rcl_interfaces/msg/Parameter"


def parameter_channel(report: Report) -> Channel:
    """Return the channel that sets parameters. report: reports whether a parameter was set."""

    def apply(live: LiveSimulator, message: Any) -> None:
        value = value_of(message.value)
        done = live.command("set_parameter", name=message.name, value=value)
        done.add_done_callback(lambda done: answer(message.name, value, done))

    def answer(name: str, value: Any, done: Future[Any]) -> None:
        error = None if done.cancelled() else done.exception()
        report(WARN if error else INFO, f"/{NAME}: {error}" if error else f"/{NAME}: {name} = {value}")

    return Channel(NAME, TYPE, "in", "set a parameter of the simulation, such as rov.drag.linear.surge", apply=apply)
