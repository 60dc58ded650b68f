"""A vehicle's command services, one for each entry of the command table with a service type."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from uwsim.base.arguments import plain
from uwsim.base.commands import COMMANDS, SET_BOOL, Command
from uwsim.channels.channel import Service
from uwsim.channels.request import Request, answered, field
from uwsim.channels.source import Source
from uwsim.channels.steering import Steering, require_link
from uwsim.live import LiveSimulator


def command_services(source: Source, steering: Steering) -> list[Service]:
    """Return a vehicle's command services. A request's fields are the command's arguments, or `data` for SetBool."""
    return [
        Service(
            source.topic(command.name), command.service, answered(_given(source.name, command, steering)),
            command.description, is_vital=command.is_vital, rights=steering.rights,
        )
        for command in COMMANDS.values()
        if command.service
    ]  # fmt: skip


def _given(vehicle: str, command: Command, steering: Steering) -> Callable[[LiveSimulator, Request], object]:
    def give(live: LiveSimulator, request: Request) -> object:
        arguments = arguments_of(command, request)
        require_link(live, vehicle, command.name)
        if command.steers or command.is_vital:
            steering.watch.forget()
        if command.steers:
            return steering.give(live, command.name, **arguments).result()
        return live.command(command.name, vehicle=vehicle, **arguments).result()

    return give


def arguments_of(command: Command, request: Request) -> dict[str, Any]:
    """Extract a command's arguments from a service request. Raises ValueError for a SetBool without `data`."""
    if command.service == SET_BOOL:
        return {command.arguments[0].name: field(request, "data", bool, None)}
    return dict(request)


def named_arguments(service: Service, values: list[Any]) -> Request:
    """Return a request whose fields have these values, in order. Raises ValueError if there are too many values."""
    command = COMMANDS.get(service.name.rpartition("/")[2])
    names = ["data"] if service.type == SET_BOOL else [each.name for each in command.arguments] if command else []
    if len(values) > len(names):
        fields = f"{len(names)} at most: {', '.join(names)}" if names else "an object, since it has no positional ones"
        raise ValueError(f"service '{service.name}': {len(values)} args: must be {fields}")
    return dict(zip(names, values, strict=False))


def request_of(command: Command, arguments: Mapping[str, Any]) -> Request:
    """Return the service request that issues a command."""
    if command.service == SET_BOOL:
        flag = command.arguments[0]
        return {"data": bool(arguments.get(flag.name, flag.default))}
    return {name: plain(value, name) for name, value in arguments.items()}
