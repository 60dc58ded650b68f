"""The /set_parameter topic, which replaces the ROS 2 service: each rcl_interfaces/Parameter sets one parameter."""

from __future__ import annotations

from concurrent.futures import Future
from typing import Any

from uwsim.bridges.ros2.rosout import INFO, WARN
from uwsim.bridges.ros2.service_topics import Say
from uwsim.channels import Channel
from uwsim.live import LiveSimulator

NAME, TYPE = "set_parameter", "rcl_interfaces/msg/Parameter"
FIELDS = {  # fields of rcl_interfaces/ParameterValue, by rcl_interfaces/ParameterType
    1: "bool_value", 2: "integer_value", 3: "double_value", 4: "string_value", 5: "byte_array_value",
    6: "bool_array_value", 7: "integer_array_value", 8: "double_array_value", 9: "string_array_value",
}  # fmt: skip


def parameter_channel(say: Say) -> Channel:
    """Return the channel that sets parameters. say: reports whether a parameter was set."""

    def apply(live: LiveSimulator, message: Any) -> None:
        value = value_of(message.value)
        done = live.command("set_parameter", name=message.name, value=value)
        done.add_done_callback(lambda done: answer(message.name, value, done))

    def answer(name: str, value: Any, done: Future[Any]) -> None:
        error = None if done.cancelled() else done.exception()
        say(WARN if error else INFO, f"/{NAME}: {error}" if error else f"/{NAME}: {name} = {value}")

    return Channel(NAME, TYPE, "in", "set a parameter of the simulation, such as rov.drag.linear.surge", apply=apply)


def value_of(value: Any) -> Any:
    """Return the value in a rcl_interfaces/ParameterValue. Raises ValueError if its type is unknown."""
    if value.type not in FIELDS:
        raise ValueError(
            f"value.type = {value.type}: must be one of {', '.join(f'{n} ({f})' for n, f in FIELDS.items())}"
        )
    found = getattr(value, FIELDS[value.type])
    return found.tolist() if hasattr(found, "tolist") else found
