"""The parameter services of a ROS 2 node (rcl_interfaces), for the simulator's parameters."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from typing import Any

from uwsim.base.texts.json_text import json_value
from uwsim.channels.calls.parameter_table import ParameterTable
from uwsim.channels.channel import Service
from uwsim.live import LiveSimulator
from uwsim.simulator.parameters import Parameter

Request = dict[str, Any]
FIELDS = {  # fields of rcl_interfaces/ParameterValue, by rcl_interfaces/ParameterType
    1: "bool_value", 2: "integer_value", 3: "double_value", 4: "string_value", 5: "byte_array_value",
    6: "bool_array_value", 7: "integer_array_value", 8: "double_array_value", 9: "string_array_value",
}  # fmt: skip
NOT_SET, TEXT = 0, 4
SCALARS: dict[type, int] = {bool: 1, int: 2, float: 3, str: TEXT}
ARRAYS: dict[type, int] = {bool: 6, int: 7, float: 8, str: 9}
EXPECTED = {"flag": 1, "whole number": 2, "number": 3, "text": TEXT}
"""The type of a parameter without a value, by the type that `describe` returns."""


def rcl_parameter_services(node: str) -> list[Service]:
    """Return the services that tools such as `ros2 param` call. node: the node's name."""
    calls: dict[str, tuple[Callable[[LiveSimulator, Request], Request], str]] = {
        "ListParameters": (_list, "names at and below request.prefixes, down to request.depth levels; 0: all"),
        "GetParameters": (_get, "values of request.names"),
        "GetParameterTypes": (_types, "types of request.names"),
        "DescribeParameters": (_describe, "descriptions, units and ranges of request.names"),
        "SetParameters": (_set, "set each of request.parameters that is valid"),
        "SetParametersAtomically": (_set_all, "set all of request.parameters, or none"),
    }
    spelled = {name: "".join(f"_{c.lower()}" if c.isupper() else c for c in name)[1:] for name in calls}
    return [
        Service(f"{node}/{spelled[name]}", f"rcl_interfaces/srv/{name}", call, description)
        for name, (call, description) in calls.items()
    ]


def value_of(value: Any) -> Any:
    """Return the value in a rcl_interfaces/ParameterValue. Raises ValueError if its type is unknown."""
    if value.type not in FIELDS:
        raise ValueError(
            f"value.type = {value.type}: must be one of {', '.join(f'{n} ({f})' for n, f in FIELDS.items())}"
        )
    found = getattr(value, FIELDS[value.type])
    return found.tolist() if hasattr(found, "tolist") else found


def plain_value(value: Any) -> Request:
    """Return a value in the form of a rcl_interfaces/ParameterValue. Types unknown to ROS become JSON text."""
    kind = type_of(value)
    if kind == NOT_SET:
        return {"type": NOT_SET}
    return {"type": kind, FIELDS[kind]: value if kind != TEXT or isinstance(value, str) else json.dumps(value)}


def type_of(value: Any) -> int:
    """Return the rcl_interfaces/ParameterType of a value."""
    if value is None:
        return NOT_SET
    if isinstance(value, list):
        kinds = {type(part) for part in value} or {float}
        return ARRAYS.get(kinds.pop(), TEXT) if len(kinds) == 1 else TEXT
    return SCALARS.get(type(value), TEXT)


def _list(live: LiveSimulator, request: Request) -> Request:
    def is_near(below: str) -> bool:
        return not request["depth"] or below.count(".") < request["depth"]

    prefixes = request["prefixes"]
    names = [
        name
        for name in ParameterTable(live).own
        if (not prefixes and is_near(name))
        or any(
            name == prefix or (name.startswith(f"{prefix}.") and is_near(name[len(prefix) + 1 :]))
            for prefix in prefixes
        )
    ]
    groups = dict.fromkeys(name.rpartition(".")[0] for name in names if "." in name)
    return {"result": {"names": names, "prefixes": list(groups)}}


def _get(live: LiveSimulator, request: Request) -> Request:
    return {"values": [plain_value(one and one.value) for one in ParameterTable(live).known(request["names"])]}


def _types(live: LiveSimulator, request: Request) -> Request:
    return {
        "types": [NOT_SET if one is None else _declared(one) for one in ParameterTable(live).known(request["names"])]
    }


def _declared(one: Parameter) -> int:
    """Return the type of a parameter or, if it has no value, the type that its value would have."""
    return EXPECTED.get(one.type, NOT_SET) if one.value is None else type_of(one.value)


def _describe(live: LiveSimulator, request: Request) -> Request:
    asked: Sequence[str] = request["names"]
    return {
        "descriptors": [
            _described(name, one) for name, one in zip(asked, ParameterTable(live).known(asked), strict=True)
        ]
    }


def _described(name: str, one: Parameter | None) -> Request:
    if one is None:
        return {"name": name}
    unit = f" [{one.unit}]" if one.unit else ""
    kind = _declared(one)
    span = {} if one.low is None or kind not in (2, 3) else {"from_value": one.low, "to_value": one.high}
    ranges = {"integer_range" if kind == 2 else "floating_point_range": [span]} if span else {}
    return {
        "name": name, "type": kind, "description": f"{one.description}{unit}",
        "additional_constraints": one.range_text, "dynamic_typing": one.optional, **ranges,
    }  # fmt: skip


def _set(live: LiveSimulator, request: Request) -> Request:
    return {"results": _each_changed(live, request["parameters"])}


def _each_changed(live: LiveSimulator, parameters: Sequence[Any]) -> list[Request]:
    """Set each parameter that is valid, in few commands, since each of them checks the whole scenario."""
    result = _changed(live, parameters)
    if result["successful"] or len(parameters) == 1:
        return [result] * len(parameters)
    half = len(parameters) // 2
    return [*_each_changed(live, parameters[:half]), *_each_changed(live, parameters[half:])]


def _set_all(live: LiveSimulator, request: Request) -> Request:
    return {"result": _changed(live, request["parameters"])}


def _changed(live: LiveSimulator, parameters: Sequence[Any]) -> Request:
    """Set all parameters (messages of type rcl_interfaces/Parameter) or none; return a SetParametersResult.

    A parameter that has its new value already is left alone, since some values can be read but not set: those that
    follow from others.
    """
    try:
        known = ParameterTable(live).known(one.name for one in parameters)
        wanted = [_wanted(one, now) for one, now in zip(parameters, known, strict=True)]
        changes = {
            one.name: value
            for one, now, value in zip(parameters, known, wanted, strict=True)
            if now is None or (type_of(now.value), now.value) != (one.value.type, value)
        }
        if changes:
            ParameterTable(live).set(changes).result()
    except ValueError as error:
        return {"successful": False, "reason": str(error)}
    return {"successful": True, "reason": ""}


def _wanted(one: Any, known: Parameter | None) -> Any:
    if one.value.type == NOT_SET:
        return None
    value = value_of(one.value)
    if isinstance(value, str) and known is not None and known.type in ("list", "structure"):
        return json_value(value, one.name)
    return value
