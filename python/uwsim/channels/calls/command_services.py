"""A vehicle's command services, one for each entry of the command table with a service type."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from typing import Any

from uwsim.base.arguments import plain
from uwsim.base.commands import COMMANDS, SET_BOOL, Command
from uwsim.base.commands.command import VEHICLE
from uwsim.channels.authority.steering import Steering, require_link
from uwsim.channels.channel import Service
from uwsim.channels.request import Request, answered, answered_later, field
from uwsim.channels.ros.service_types import SERVICE_TYPES, field_names, halves
from uwsim.channels.source import Source
from uwsim.live import LiveSimulator


def command_services(source: Source, steering: Steering) -> list[Service]:
    """Return a vehicle's command services. A request's fields are the command's arguments, or `data` for SetBool."""
    return [
        Service(
            source.topic(command.name), command.service, _called(source.name, command, steering),
            command.description, is_vital=command.is_vital, permit=steering.rights.require,
        )
        for command in COMMANDS.values()
        if command.service and command.of != "simulator"
    ]  # fmt: skip


def push_service() -> Service:
    """Return the service that pushes loose bodies."""
    command = COMMANDS["push_object"]
    return Service(
        f"simulation/{command.name}", command.service,
        answered(lambda live, request: live.command(command.name, **request).result()), command.description,
    )  # fmt: skip


def _called(vehicle: str, command: Command, steering: Steering) -> Callable[[LiveSimulator, Request], Any]:
    def begin(live: LiveSimulator, request: Request) -> Future[Any]:
        arguments = arguments_of(command, request)
        require_link(live, vehicle, command.name)
        if command.steers or command.is_vital:
            steering.forget()
        if command.steers:
            return steering.give(live, command.name, **arguments)
        return live.command(command.name, vehicle=vehicle, **arguments)

    if command.is_vital:
        return answered_later(begin)
    return answered(lambda live, request: begin(live, request).result())


def arguments_of(command: Command, request: Request) -> dict[str, Any]:
    """Extract a command's arguments from a service request. Raises ValueError, as for a SetBool without `data`."""
    if VEHICLE.name in request:
        raise ValueError(f"command '{command.name}': '{VEHICLE.name}': each vehicle has a service of its own")
    if command.service == SET_BOOL:
        return {command.arguments[0].name: field(request, "data", bool, None)}
    return dict(request)


def named_arguments(service: Service, values: list[Any]) -> Request:
    """Return a request whose fields have these values, in order. Raises ValueError if there are too many values."""
    names = field_names(halves(service.type)[0]) if service.type in SERVICE_TYPES else []
    return by_field(service.name, names, values)


def by_field(service: str, names: Sequence[str], values: Sequence[Any]) -> Request:
    """Return values, given in order, by the names of a request's fields. Raises ValueError if there are too many."""
    if len(values) > len(names):
        fields = f"{len(names)} at most: {', '.join(names)}" if names else "none, since its request has no fields"
        raise ValueError(f"service '{service}': {len(values)} args: must be {fields}")
    return dict(zip(names, values, strict=False))


def request_of(command: Command, arguments: Mapping[str, Any]) -> Request:
    """Return the service request that issues a command."""
    if command.service == SET_BOOL:
        flag = command.arguments[0]
        return {"data": bool(arguments.get(flag.name, flag.default))}
    return {name: plain(value, name) for name, value in arguments.items()}
