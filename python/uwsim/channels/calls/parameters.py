"""Services that list, get, set and reset the simulator's parameters. Values are strings that contain JSON."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from uwsim.base.texts.json_text import json_object
from uwsim.channels.calls.parameter_table import ParameterTable
from uwsim.channels.channel import Service
from uwsim.channels.ros.message_types import shortened
from uwsim.live import LiveSimulator

Request = dict[str, Any]


def parameter_services() -> list[Service]:
    """Return the parameter services. Each response contains success, message and the requested values."""
    return [
        Service(
            "simulation/list_parameters", "uwsim_msgs/srv/ListParameters", _list,
            "the names at and below request.prefix, all by default",
        ),
        Service(
            "simulation/get_parameters", "uwsim_msgs/srv/GetParameters", _get,
            "values_json, of request.names: an object of values by name",
        ),
        Service(
            "simulation/describe_parameters", "uwsim_msgs/srv/DescribeParameters", _describe,
            "descriptions_json, of request.names: type, unit, low, high, choices, value, default, description of each",
        ),
        Service(
            "simulation/set_parameters", "uwsim_msgs/srv/SetParameters", _set,
            "set all of request.values_json, an object of values by name, or none",
        ),
        Service(
            "simulation/reset_parameters", "uwsim_msgs/srv/ResetParameters", _reset,
            "return to the scenario's values at and below each of request.names; without names, to all",
        ),
    ]  # fmt: skip


def _list(live: LiveSimulator, request: Request) -> Request:
    return _answered(lambda: {"names": ParameterTable(live).own.list(_text(request, "prefix", ""))})


def _get(live: LiveSimulator, request: Request) -> Request:
    own = ParameterTable(live).own
    return _answered(lambda: {"values_json": json.dumps({name: own[name] for name in _names(request)})})


def _describe(live: LiveSimulator, request: Request) -> Request:
    own = ParameterTable(live).own
    return _answered(
        lambda: {"descriptions_json": json.dumps([asdict(own.describe(name)) for name in _names(request)])}
    )


def _set(live: LiveSimulator, request: Request) -> Request:
    def act() -> None:
        ParameterTable(live).set(json_object(_text(request, "values_json", None), "values_json")).result()

    return _answered(act)


def _reset(live: LiveSimulator, request: Request) -> Request:
    return _answered(lambda: ParameterTable(live).reset(_names(request)))


def _answered(act: Callable[[], Request | None]) -> Request:
    try:
        return {"success": True, "message": "", **(act() or {})}
    except (ValueError, RecursionError) as error:
        return {"success": False, "message": str(error)}


def _text(request: Request, name: str, default: str | None) -> str:
    value = request.get(name, default)
    if not isinstance(value, str):
        raise ValueError(f"{name} = {shortened(value)}: must be given, as a string")
    return value


def _names(request: Request) -> list[Any]:
    names = request.get("names", [])
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise ValueError(f"names = {shortened(names)}: must be a list of strings")
    return names
