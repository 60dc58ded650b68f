"""Type descriptions for rosapi, with the fields of a type and of all types that it contains."""

from __future__ import annotations

from typing import Any

from rosbags.typesys import get_types_from_msg

from uwsim.channels.ros.message_types import Kind, fields, kind_of, resolve, spelled, typestore
from uwsim.channels.ros.messages import Ros

EXAMPLES = {"string": "", "wstring": "", "bool": "False", "float32": "0.0", "float64": "0.0"}


def message_details(type_name: Any, ros: Ros) -> list[dict[str, Any]]:
    """Return the typedefs of a message type and of all types it contains, without duplicates. Raises ValueError."""
    return _typedefs([resolve(type_name)[0]], ros)


def part_details(type_name: str, text: str, ros: Ros) -> list[dict[str, Any]]:
    """Return the typedefs of a service's request or response, from its definition in .srv syntax."""
    name = f"uwsim/msg/{type_name.split('/')[-1]}"
    definition = get_types_from_msg(text, name)[name][1]
    kinds = [(field, kind_of(description)) for field, description in definition]
    first = _typedef(type_name, kinds, [], ros)
    inner = list(dict.fromkeys(kind.base for _, kind in kinds if kind.is_message))
    return [first, *_typedefs(inner, ros)]


def _typedefs(names: list[str], ros: Ros) -> list[dict[str, Any]]:
    found: dict[str, dict[str, Any]] = {}
    while names:
        name = names.pop(0)
        if name not in found:
            kinds = [(field.name, field.kind) for field in fields(name, ros)]
            found[name] = _typedef(spelled(name, ros), kinds, typestore().fielddefs[name][0], ros)
            names.extend(kind.base for _, kind in kinds if kind.is_message)
    return list(found.values())


def _typedef(name: str, kinds: list[tuple[str, Kind]], constants: Any, ros: Ros) -> dict[str, Any]:
    return {
        "type": name,
        "fieldnames": [field for field, _ in kinds],
        "fieldtypes": [spelled(kind.base, ros) if kind.is_message else kind.base for _, kind in kinds],
        "fieldarraylen": [-1 if kind.length is None else kind.length for _, kind in kinds],
        "examples": [_example(kind) for _, kind in kinds],
        "constnames": [constant[0] for constant in constants],
        "constvalues": [str(constant[2]) for constant in constants],
    }


def _example(kind: Kind) -> str:
    if kind.length is not None:
        return "[]"
    return "{}" if kind.is_message else EXAMPLES.get(kind.base, "0")
