"""Divides observations by the usual sizes of their values, so that learners receive numbers of about 1."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.spaces import Box, Dict, Space

from uwsim.learning.task import Task

STATE = "state"
"""The part of a Dict observation that contains the task's fields."""


class Scales:
    """The usual sizes of a task's fields.

    They apply to observations whose values are the task's fields, or to the part `state` of a dict. Other parts, such
    as pictures and maps, are not changed.
    """

    def __init__(self, kind: type[Task], space: Space[Any]) -> None:
        sizes = [size for field in kind.fields() for size in field.sizes]
        self._sizes = np.array(sizes, np.float32)
        self._is_dict = isinstance(space, Dict)
        part = space.spaces.get(STATE) if isinstance(space, Dict) else space
        self._applies = isinstance(part, Box) and part.shape == self._sizes.shape and part.dtype == np.float32

    def space(self, space: Space[Any]) -> Space[Any]:
        """Return the space of normalised observations."""
        if not self._applies:
            return space
        if isinstance(space, Dict):
            return Dict({**space.spaces, STATE: self._box(space.spaces[STATE])})
        return self._box(space)

    def _box(self, box: Space[Any]) -> Box:
        assert isinstance(box, Box)
        return Box(box.low / self._sizes, box.high / self._sizes, dtype=np.float32)

    def apply(self, observation: Any) -> Any:
        """Return observations with their fields divided by the usual sizes."""
        if not self._applies:
            return observation
        if self._is_dict:
            return {**observation, STATE: observation[STATE] / self._sizes}
        return observation / self._sizes
