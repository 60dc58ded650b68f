"""The parameters that clients see by rosapi: JSON values by name, with or without a leading slash."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

MOST = 10_000
LONGEST = 100_000  # characters of a value's JSON


class Parameters:
    """Named values. present: those there are from the start, such as use_sim_time, as JSON."""

    def __init__(self, present: Mapping[str, str]) -> None:
        self._values = dict(present)

    def names(self) -> list[str]:
        """Return all names, sorted."""
        return sorted(self._values)

    def has(self, name: str) -> bool:
        """Return whether a parameter has a value."""
        return name in self._values

    def get_json(self, name: str, default: str = "null") -> str:
        """Return a parameter's value as JSON."""
        return self._values.get(name, default)

    def set_json(self, name: str, text: Any) -> None:
        """Set a parameter from JSON. Raises ValueError, changing nothing."""
        if not isinstance(text, str) or len(text) > LONGEST:
            raise ValueError(f"parameter '{name}': the value must be JSON as a string of {LONGEST} characters at most")
        try:
            json.loads(text)
        except (ValueError, RecursionError) as error:
            raise ValueError(f"parameter '{name}': not JSON ({error})") from None
        if name not in self._values and len(self._values) >= MOST:
            raise ValueError(f"parameter '{name}': there are {MOST}, which is the most")
        self._values[name] = text

    def delete(self, name: str) -> None:
        """Remove a parameter. Raises ValueError if there is none."""
        if self._values.pop(name, None) is None:
            raise ValueError(f"parameter '{name}': there is none of this name")
