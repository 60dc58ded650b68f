"""The service types in use, as .srv definitions: requests and responses for bridges whose peers have typed services.

Requests and responses are also message types, such as std_srvs/srv/Trigger_Request and std_srvs/srv/Trigger_Response.
ROS 2 computes the hash of a service from the message type std_srvs/srv/Trigger, whose fields are the request, the
response and an event; see `load_service_types`.

The types of commands are derived from the table of commands.

A field of at most one value, such as float64[<=1], is optional. A list of uwsim_msgs/NamedNumber stands for an object
of numbers by name.
"""

from __future__ import annotations

import json
import math
from functools import cache

from uwsim.base.commands import COMMANDS, SET_BOOL, TRIGGER, Argument, Command
from uwsim.channels.ros.cdr import Distro, store_of
from uwsim.channels.ros.interface_types import parsed, service_texts
from uwsim.channels.ros.message_types import ros1_typestore, typestore

OUTCOME = "bool success\nstring message\n"
_NAMED = "rcl_interfaces/Parameter[] parameters\n---\n"

SERVICE_TYPES = {
    # https://github.com/ros2/common_interfaces
    "std_srvs/srv/Trigger": f"---\n{OUTCOME}",
    "std_srvs/srv/SetBool": f"bool data\n---\n{OUTCOME}",
    # https://github.com/ros2/rcl_interfaces
    "rcl_interfaces/srv/ListParameters": (
        "string[] prefixes\nuint64 depth\n---\nrcl_interfaces/ListParametersResult result\n"
    ),
    "rcl_interfaces/srv/GetParameters": "string[] names\n---\nrcl_interfaces/ParameterValue[] values\n",
    "rcl_interfaces/srv/GetParameterTypes": "string[] names\n---\nuint8[] types\n",
    "rcl_interfaces/srv/DescribeParameters": "string[] names\n---\nrcl_interfaces/ParameterDescriptor[] descriptors\n",
    "rcl_interfaces/srv/SetParameters": f"{_NAMED}rcl_interfaces/SetParametersResult[] results\n",
    "rcl_interfaces/srv/SetParametersAtomically": f"{_NAMED}rcl_interfaces/SetParametersResult result\n",
    # https://github.com/ros2/rcl_interfaces; every action has one
    "action_msgs/srv/CancelGoal": (
        "action_msgs/GoalInfo goal_info\n---\nint8 ERROR_NONE=0\nint8 ERROR_REJECTED=1\nint8 ERROR_UNKNOWN_GOAL_ID=2\n"
        "int8 ERROR_GOAL_TERMINATED=3\nint8 return_code\naction_msgs/GoalInfo[] goals_canceling\n"
    ),
    # Our own
    "uwsim_msgs/srv/Step": f"uint32 steps 1\n---\n{OUTCOME}",
    "uwsim_msgs/srv/SetSpeed": f"float64 speed  # simulated seconds per second; 0: as fast as possible\n---\n{OUTCOME}",
    "uwsim_msgs/srv/Pace": (
        "---\nfloat64 speed\nfloat64 factor\nfloat64 lateness_s\nfloat64 slipped_s\nbool paused\nstring error\n"
        "float64 step_s\n"
    ),
    "uwsim_msgs/srv/ListParameters": f"string prefix\n---\n{OUTCOME}string[] names\n",
    "uwsim_msgs/srv/GetParameters": f"string[] names\n---\n{OUTCOME}string values_json\n",
    "uwsim_msgs/srv/DescribeParameters": f"string[] names\n---\n{OUTCOME}string descriptions_json\n",
    "uwsim_msgs/srv/SetParameters": f"string values_json\n---\n{OUTCOME}",
    "uwsim_msgs/srv/ResetParameters": f"string[] names\n---\n{OUTCOME}",
    "uwsim_msgs/srv/SetStream": (
        "bool[<=1] enabled  # values that are not given stay\nfloat64[<=1] rate_hz\nuint32[<=1] width\n"
        f"uint32[<=1] quality\n---\n{OUTCOME}"
    ),
    "uwsim_msgs/srv/SaveMap": f'string name "map.bt"\n---\n{OUTCOME}',
}
"""The definitions, by name in the spelling of ROS 2. A service whose type is not here takes any JSON."""


def definition_of(command: Command) -> str:
    """Return the definition of a command's service. Raises ValueError for an argument that no field can carry."""
    return "".join(f"{_field(argument)}\n" for argument in command.arguments) + f"---\n{OUTCOME}"


def _field(argument: Argument) -> str:
    """Return the field of a request that carries an argument, with its unit and bounds as a comment."""
    kind = _KINDS.get(argument.type, "").format(argument.length)
    is_optional = argument.default is None
    if not kind or (is_optional and kind.endswith("]")):
        raise ValueError(f"argument '{argument.name}': no field of a service can carry it: {argument.type}")
    default = argument.default
    is_zero = argument.is_required or not (any(default) if isinstance(default, tuple) else default)
    bounds = f"in [{argument.low:g}, {argument.high:g}]" if math.isfinite(argument.high - argument.low) else ""
    about = ", ".join(filter(None, (argument.unit, bounds)))
    field = f"{kind}{'[<=1]' if is_optional else ''} {argument.name}"
    return field + ("" if is_zero else f" {json.dumps(default)}") + (f"  # {about}" if about else "")


_KINDS = {
    "flag": "bool", "number": "float64", "text": "string", "numbers": "float64[{}]",
    "numbers by name": "uwsim_msgs/NamedNumber[]",
}  # fmt: skip
SERVICE_TYPES |= {
    command.service: definition_of(command)
    for command in COMMANDS.values()
    if command.service not in ("", TRIGGER, SET_BOOL)
}


def request_type(service_type: str) -> str:
    """Return the name of a service type's request."""
    return f"{service_type}_Request"


def response_type(service_type: str) -> str:
    """Return the name of a service type's response."""
    return f"{service_type}_Response"


def halves(service_type: str) -> tuple[str, str]:
    """Return the definitions of a service type's request and response."""
    request, _, response = SERVICE_TYPES[service_type].partition("---\n")
    return request, response


def field_names(definition: str) -> list[str]:
    """Return the names of the fields in a part of a definition, in order; constants are no fields."""
    lines = (line.partition("#")[0].split() for line in definition.splitlines())
    return [line[1] for line in lines if len(line) > 1 and "=" not in line[1]]


@cache
def load_service_types(distro: Distro = "jazzy") -> None:
    """Add all service types to the message types. This takes half a second, so it is done on first use."""
    found = {
        part: fields for name in SERVICE_TYPES for part, fields in parsed(service_texts(name, *halves(name))).items()
    }
    for store in (typestore(), ros1_typestore(), store_of(distro)):
        store.register({name: fields for name, fields in found.items() if name not in store.fielddefs})
