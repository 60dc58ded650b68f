"""RIHS01, the hash that distinguishes versions of a type in ROS 2 (REP 2016): SHA-256 of its description in JSON."""

from __future__ import annotations

import hashlib
import json
from typing import Any

from rosbags.typesys.store import Typestore

from uwsim.channels.ros.message_types import Kind, kind_of

# type_description_interfaces/msg/FieldType. A char in a .msg file is an unsigned byte, unlike one in IDL, which is 13.
NESTED = 1
NUMBERS = {
    "int8": 2, "uint8": 3, "char": 3, "int16": 4, "uint16": 5, "int32": 6, "uint32": 7, "int64": 8, "uint64": 9,
    "float32": 10, "float64": 11, "float128": 12, "bool": 15, "byte": 16, "octet": 16, "string": 17, "wstring": 18,
}  # fmt: skip
BOUNDED_STRING = {"string": 21, "wstring": 22}
ARRAY, BOUNDED, UNBOUNDED = 48, 96, 144  # added to the element's number


def type_hash(store: Typestore, name: str) -> str:
    """Return the hash of a type in a store, such as "RIHS01_df668c74...". For services, see `service_types`."""
    found: dict[str, dict[str, Any]] = {}
    pending = [name]
    while pending:
        one = pending.pop()
        if one not in found:
            kinds = [(field, kind_of(description)) for field, description in store.fielddefs[one][1]]
            found[one] = {"type_name": one, "fields": [_field(field, kind) for field, kind in kinds]}
            pending += [kind.base for _, kind in kinds if kind.is_message]
    described = {
        "type_description": found.pop(name),
        "referenced_type_descriptions": [found[other] for other in sorted(found)],
    }
    return f"RIHS01_{hashlib.sha256(json.dumps(described).encode()).hexdigest()}"


def _field(name: str, kind: Kind) -> dict[str, Any]:
    text_limit = 0
    if kind.is_message:
        number = NESTED
    elif kind.base in BOUNDED_STRING and kind.length is None and kind.limit:
        number, text_limit = BOUNDED_STRING[kind.base], kind.limit
    else:
        number = NUMBERS[kind.base]
    capacity = 0
    if kind.length is not None:
        capacity = kind.length or kind.limit
        number += ARRAY if kind.length else BOUNDED if kind.limit else UNBOUNDED
    return {
        "name": name,
        "type": {
            "type_id": number,
            "capacity": capacity,
            "string_capacity": text_limit,
            "nested_type_name": kind.base if kind.is_message else "",
        },
    }
