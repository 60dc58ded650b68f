"""The kinds of faults and their fields, from which the instructor's page makes its form."""

from __future__ import annotations

from typing import Annotated, Any, get_args, get_origin

from pydantic.fields import FieldInfo

from uwsim.channels.guest import Values
from uwsim.scenario.spec.descriptions import descriptions, summary
from uwsim.scenario.spec.fault import FAULTS, FaultModel
from uwsim.simulator.parameters.field_type import field_type, stripped

COMMON = ("name", "vehicle", "at_s", "rate_per_h")  # fields that the instructor leaves out: the fault begins now


def fault_kinds() -> list[Values]:
    """Return the registered kinds of faults; see uwsim.operator.station.wire.training.FaultKind."""
    return [_kind(kind, model) for kind, model in FAULTS.models().items()]


def _kind(kind: str, model: type[FaultModel]) -> Values:
    words, parts = descriptions(model), model.parts()
    names = sorted(model.model_fields, key=FaultModel.model_fields.__contains__)  # its own first
    fields = [
        {
            **_type(model.model_fields[name]),
            "name": name,
            "meaning": words.get(name, ""),
            "part": parts.get(name, ""),
            "value": model.example.get(name, model.model_fields[name].get_default()),
        }
        for name in names
        if name not in (*COMMON, "kind")
    ]
    return {"kind": kind, "meaning": summary(model), "fields": [_plain(field) for field in fields]}


def _type(info: FieldInfo) -> Values:
    annotation, metadata, optional = stripped(Annotated[info.annotation, *info.metadata, None], None)
    width = 1
    if get_origin(annotation) is tuple:
        width = len(get_args(annotation))
        annotation, metadata, _ = stripped(get_args(annotation)[0], None)
    found = field_type(annotation, metadata, optional)
    choices = [True, False] if found.type == "flag" else list(found.choices)
    is_number = found.type in ("number", "whole number")
    return {
        "is_number": is_number, "width": width, "unit": found.unit, "low": found.low, "high": found.high,
        "choices": choices, "is_optional": not info.is_required(),
    }  # fmt: skip


def _plain(field: dict[str, Any]) -> Values:
    value = field["value"]
    if isinstance(value, tuple):
        value = list(value)
    return {**field, "value": value if isinstance(value, str | float | int | list) else None}
