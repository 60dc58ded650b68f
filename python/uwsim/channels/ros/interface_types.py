"""The message types that ROS 2 derives from the definitions of services and actions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rosbags.interfaces import Nodetype
from rosbags.typesys import get_types_from_msg

from uwsim.channels.ros.message_types import EMPTY_PLACEHOLDER

PLACEHOLDER = [(EMPTY_PLACEHOLDER, (Nodetype.BASE, ("uint8", 0)))]


def service_texts(name: str, request: str, response: str) -> dict[str, str]:
    """Return the definitions of a service's message types, including the type from which its hash is computed."""
    asked, answered, event = f"{name}_Request", f"{name}_Response", f"{name}_Event"
    return {
        asked: request,
        answered: response,
        event: f"service_msgs/ServiceEventInfo info\n{asked}[<=1] request\n{answered}[<=1] response\n",
        name: f"{asked} request_message\n{answered} response_message\n{event} event_message\n",
    }


def action_texts(name: str, goal: str, result: str, feedback: str) -> dict[str, str]:
    """Return the definitions of an action's message types and services, as rosidl generates them."""
    identity = "unique_identifier_msgs/UUID goal_id\n"
    sent = f"{identity}{name}_Goal goal\n", "bool accepted\nbuiltin_interfaces/Time stamp\n"
    asked = identity, f"int8 status\n{name}_Result result\n"
    return {
        f"{name}_Goal": goal,
        f"{name}_Result": result,
        f"{name}_Feedback": feedback,
        **service_texts(f"{name}_SendGoal", *sent),
        **service_texts(f"{name}_GetResult", *asked),
        f"{name}_FeedbackMessage": f"{identity}{name}_Feedback feedback\n",
        name: (
            f"{name}_Goal goal\n{name}_Result result\n{name}_Feedback feedback\n{name}_SendGoal send_goal_service\n"
            f"{name}_GetResult get_result_service\n{name}_FeedbackMessage feedback_message\n"
        ),
    }


def parsed(texts: Mapping[str, str]) -> dict[str, Any]:
    """Return message types by name, as rosbags stores them. The definitions may refer to each other."""
    in_rosbags = {_as_message(name): name for name in texts}  # its parser accepts only "msg" in the middle of a name

    def restored(kind: Any) -> Any:
        if isinstance(kind, str):
            return in_rosbags.get(kind, kind)
        return tuple(map(restored, kind)) if isinstance(kind, tuple) else kind

    found = {}
    for name, text in texts.items():
        constants, fields = get_types_from_msg(_as_message(text), _as_message(name))[_as_message(name)]
        found[name] = constants, [(field, restored(kind)) for field, kind in fields] or PLACEHOLDER
    return found


def _as_message(text: str) -> str:
    return text.replace("/srv/", "/msg/").replace("/action/", "/msg/")
