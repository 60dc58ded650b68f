"""Makes the page's module wire/messages.js, which the site serves.

It contains a function for each station service, the types of requests, responses and topic messages, and those tables
of Python that the page needs.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from types import NoneType, UnionType
from typing import Any, Literal, get_args, get_origin

from uwsim import _core
from uwsim.base.axes import AXES
from uwsim.base.commands import COMMANDS, HOLDS
from uwsim.base.commands.notes import NoteCategory
from uwsim.channels.families.map_changes import EDGE
from uwsim.channels.ros.message_types import Kind, fields
from uwsim.channels.ros.own_types import ALL_STOPPED, LINK, MAP_CHANGES, SENSOR_GAUGES, STATION_STATE, TELEMETRY
from uwsim.instruments.gauges import SHOWN
from uwsim.instruments.sonars.imaging.pixels import ABOVE_MEDIAN_DB, AMBER, BELOW_MEDIAN_DB
from uwsim.operator.station.controls.plan import SPEEDS_M_S
from uwsim.operator.station.services.services import DEAD_S
from uwsim.operator.station.wire.calls import CALLS, Call
from uwsim.operator.station.wire.messages import Message, Refused

TOPIC_TYPES = (STATION_STATE, TELEMETRY, SENSOR_GAUGES, MAP_CHANGES, LINK)
HEAD = """\
/** @typedef {{ stamp: { sec: number, nanosec: number }, frame_id: string }} Header */
/** @typedef {ArrayLike<number> & Iterable<number>} Numbers */
/** @typedef {{ call(service: string, args?: object): Promise<any> }} Caller */
"""
NUMBER = re.compile(r"u?int\d+|float\d+|byte|octet")


def messages_js() -> str:
    """Return the module's text."""
    parts = [HEAD, _constants(), *map(_topic_type, TOPIC_TYPES), *_typedefs(), *map(_function, CALLS.values())]
    return "\n".join(parts)


def _constants() -> str:
    types = {name.split("/")[-1]: name.replace("/msg/", "/") for name in TOPIC_TYPES}
    piloted = [command for command in COMMANDS.values() if command.is_piloted]
    commands = {command.name: [argument.name for argument in command.arguments] for command in piloted}
    gauges = [
        {"name": each.name, **({"word": each.called} if each.called else {}), "unit": each.unit}
        | {"list": each.shown_in}
        for each in SHOWN
    ]
    return "".join(
        f"{comment}export const {name} = {json.dumps(value)};\n"
        for name, value, comment in (
            ("AXES", list(AXES), ""),
            ("ALL_STOPPED", ALL_STOPPED, "// The alarm in the telemetry of a vehicle whose all stop is set.\n"),
            ("FREE_S", DEAD_S, "// The silence of a pilot after which others may take the controls.\n"),
            ("PLAN_SPEEDS_M_S", list(SPEEDS_M_S), "// The bounds of a plan's speed.\n"),
            ("BLOCK_EDGE", EDGE, "// The cells along an axis of the map's blocks.\n"),
            ("SONAR_KINDS", _core.imaging_kinds(), "// The kinds of views from imaging sonars.\n"),
            ("SONAR_COLOURS", list(AMBER), "// Those of sonar pictures, from the weakest to the strongest level.\n"),
            ("SONAR_SPAN_DB", BELOW_MEDIAN_DB + ABOVE_MEDIAN_DB, "// Between the first and the last of them.\n"),
            ("NOTE_CATEGORIES", list(get_args(NoteCategory)), ""),
            ("GAUGES", gauges, "// The fields of the telemetry that are gauges, in the order of the panel.\n"),
            ("HOLDS", list(HOLDS), "// The arguments of the command `hold`.\n"),
            ("TYPES", types, "// The types of topics, by their last name.\n"),
            ("COMMANDS", commands, "// The arguments of each command that the pilot may give by name.\n"),
        )
    )


def _function(call: Call) -> str:
    """Return the function that calls a service, sending only fields known to the service."""
    name = re.sub(r"_(\w)", lambda match: match[1].upper(), call.name)
    names = ", ".join(call.request.model_fields)
    given = f", {{ {names} }}" if names else ""
    sentence = call.description[0].upper() + call.description[1:]
    request = f" * @param {{{call.request.__name__}}} request\n" if names else ""
    answer = f" * @returns {{Promise<{call.answer.__name__} | Refused>}}\n"
    comment = f"/** {sentence}.\n * @param {{Caller}} bridge\n{request}{answer} */\n"
    return f"{comment}export const {name} = (bridge{given}) => bridge.call('/station/{call.name}'{given});\n"


def _typedefs() -> Iterator[str]:
    """Yield the types of all responses, each after the types that it uses."""
    done: dict[str, str] = {}

    def visit(found: Any) -> None:
        for part in get_args(found):
            visit(part)
        if (
            not (isinstance(found, type) and issubclass(found, Message))
            or not found.model_fields
            or found.__name__ in done
        ):
            return
        rows = []
        for name, field in found.model_fields.items():
            visit(field.annotation)
            key = name if field.is_required() else f"[{name}]"
            rows.append(f" * @property {{{_js(field.annotation)}}} {key}\n")
        head = f"/** {' '.join(str(found.__doc__).split())}\n * @typedef {{object}} {found.__name__}\n"
        done[found.__name__] = f"{head}{''.join(rows)} */\n"

    for found in (*(each for call in CALLS.values() for each in (call.request, call.answer)), Refused):
        visit(found)
    yield from done.values()


def _js(hint: Any) -> str:
    """Return a Python type in JSDoc notation."""
    origin, parts = get_origin(hint), get_args(hint)
    if origin is Literal:
        return " | ".join(json.dumps(part) for part in parts)
    if origin is UnionType:
        return " | ".join(_js(part) for part in parts)
    if origin is list:
        inner = _js(parts[0])
        return f"({inner})[]" if "|" in inner else f"{inner}[]"
    if origin is dict:
        return f"Record<string, {_js(parts[1])}>"
    names = {str: "string", int: "number", float: "number", bool: "boolean", NoneType: "null", Any: "any"}
    return names[hint] if hint in names else str(hint.__name__)


def _topic_type(name: str) -> str:
    rows = [f" * @property {{{_ros(field.kind)}}} {field.name}\n" for field in fields(name, 2)]
    return f"/** @typedef {{object}} {name.split('/')[-1]}\n{''.join(rows)} */\n"


def _ros(kind: Kind) -> str:
    """Return a ROS type as represented in the page, where arrays of numbers are typed arrays."""
    known = {"string": "string", "bool": "boolean", "std_msgs/msg/Header": "Header"}
    base = "number" if NUMBER.fullmatch(kind.base) else known.get(kind.base, "object")
    if kind.length is None:
        return base
    return "Numbers" if base == "number" else f"{base}[]"
