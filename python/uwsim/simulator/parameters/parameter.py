"""Parameter: the name, value, type, unit, range and description of a scenario parameter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from uwsim.simulator.parameters.field_type import Type


@dataclass(frozen=True)
class Parameter:
    """A parameter, as returned by `describe`.

    name: such as "rov.drag.linear.surge". key: its key in the scenario. value: current value; default: the scenario's
    value. low, high: limits in `unit`, None if unlimited. choices: permitted values of a "choice". optional: whether
    None is also permitted.
    """

    name: str
    key: str
    type: Type
    value: Any
    default: Any
    unit: str = ""
    low: float | None = None
    high: float | None = None
    choices: tuple[Any, ...] = ()
    optional: bool = False
    description: str = ""

    @property
    def range_text(self) -> str:
        """The range or the choices as text."""
        if self.choices:
            return ", ".join(map(str, self.choices))
        if self.type == "flag":
            return "true, false"
        text = "" if self.low is None else f"[{self.low:.12g}, {self.high:.12g}]"
        return f"{text} or none" if text and self.optional else text


def plain(value: Any) -> Any:
    """Convert a value to JSON types: tuples become lists, models dicts."""
    if hasattr(value, "model_dump"):
        return plain({key: getattr(value, key) for key in type(value).model_fields})
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, tuple | list):
        return [plain(item) for item in value]
    if hasattr(value, "tolist"):
        return value.tolist()
    return value if value is None or isinstance(value, bool | int | float | str) else str(value)
