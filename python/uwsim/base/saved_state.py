"""Saved states: each part of a simulator saves its own state, and restores it after validation by a model.

A saved state consists of the state of the native simulation and a JSON object with the state of each Python part, by
name. It may come from an untrusted source, so it is checked completely before any part of it is used.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import cache
from typing import Annotated, Any, ClassVar, Protocol, TypeVar

from pydantic import VERSION, BaseModel, ConfigDict, Field, ValidationError, create_model

from uwsim import _core
from uwsim.base.agenda import NEVER

DEFER_BUILD = tuple(int(part) for part in VERSION.split(".")[:2]) >= (2, 14)
"""Before pydantic 2.14, threads that use a model for the first time at once may validate with its base's rules
(pydantic pull request 13438)."""


KEYS = ("lamps", "parameters", "cameras", "estimates", "programs", "events")  # in the order in which they are written
Origin = tuple[str, str]
"""The fingerprints of the scenario and of the build."""
M = TypeVar("M", bound=BaseModel)


class State(BaseModel):
    """Base model for the state of a part: all keys are required, others are forbidden, and types are not converted.

    Its subclasses' validators are built when a state is restored, since few simulators ever restore one.
    """

    model_config = ConfigDict(extra="forbid", strict=True, defer_build=DEFER_BUILD)


Tick = Annotated[int, Field(ge=0, le=2 * NEVER)]
Nanoseconds = Annotated[int, Field(ge=0, lt=2**63)]


class Part(Protocol):
    """A stateful part of a simulator. STATE: the type of its state, validated by pydantic."""

    STATE: ClassVar[Any]

    def save(self) -> Any:
        """Return the state, as JSON values."""

    def restore(self, state: Any) -> None:
        """Continue from a state of type STATE. Raises ValueError if the state belongs to a different simulator."""


class SavedState:
    """Saves and restores the complete state of a simulator."""

    def __init__(
        self,
        core: _core.Simulation,
        before: Mapping[str, Part],
        after: Mapping[str, Part],
        resume: Callable[[], object],
    ) -> None:
        """before, after: the parts that are restored before and after the native simulation, in order.

        resume: called once the native simulation has been restored.
        """
        self._core, self._before, self._after, self._resume = core, before, after, resume
        self._parts = {**before, **after}

    def save(self, origin: Origin) -> bytes:
        """Return the state of the native simulation and of all parts."""
        return self._core.save_state(*origin, json.dumps({key: self._parts[key].save() for key in KEYS}))

    def restore(self, state: bytes, origin: Origin) -> None:
        """Restore a state returned by `save`. Raises ValueError, changing nothing, if it is invalid."""
        before, states = self.save(origin), self._read(state, origin)
        try:
            self._put(state, origin, states)
        except Exception:
            self._put(before, origin, self._read(before, origin))
            raise

    def _put(self, state: bytes, origin: Origin, states: Mapping[str, Any]) -> None:
        for key, part in self._before.items():
            part.restore(states[key])
        self._core.restore_state(state, *origin)
        self._resume()
        for key, part in self._after.items():
            part.restore(states[key])

    def _read(self, state: bytes, origin: Origin) -> dict[str, Any]:
        model = _model(tuple((key, part.STATE) for key, part in self._parts.items()))
        return dict(checked(model, _core.saved_notes(state, *origin)))


@cache
def _model(types: tuple[tuple[str, Any], ...]) -> type[State]:
    fields: dict[str, Any] = {key: (kind, ...) for key, kind in types}
    return create_model("States", __base__=State, **fields)


def checked(model: type[M], text: str) -> M:
    """Validate a state saved as JSON. Raises ValueError for the first invalid value."""
    try:
        return model.model_validate_json(text)
    except ValidationError as error:
        first = error.errors()[0]
        path = ".".join(str(part) for part in ("state", *first["loc"]))
        raise ValueError(f"{path} = {first['input']!r:.60}: {first['msg']}") from None
