"""Converts requests and responses between messages, for peers, and plain values, for `Service.call`."""

from __future__ import annotations

from typing import Any

from uwsim.channels.ros.message_in import from_plain
from uwsim.channels.ros.message_types import fields
from uwsim.channels.ros.own_types import NAMED_NUMBER
from uwsim.channels.ros.service_types import request_type, response_type


def request_values(service_type: str, message: Any) -> dict[str, Any]:
    """Return a request's fields, except unset optional fields. Nested messages are not converted."""
    found: dict[str, Any] = {}
    for field in fields(request_type(service_type), 2):
        value, kind = getattr(message, field.name), field.kind
        value = value.tolist() if hasattr(value, "tolist") else value
        if kind.length == 0 and kind.limit == 1:
            if not value:
                continue
            value = value[0]
        elif kind.base == NAMED_NUMBER:
            value = {one.name: one.value for one in value}
        found[field.name] = value
    return found


def response_message(service_type: str, succeeded: bool, values: Any) -> Any:
    """Return the response to a call, from its values or the reason for its failure.

    A failure is reported in the fields `success` and `message`. In a type without these fields, all values are empty.
    """
    name = response_type(service_type)
    found = values if succeeded else {"success": False, "message": values}
    known = {field.name for field in fields(name, 2)}
    return from_plain(name, {key: value for key, value in found.items() if key in known})
