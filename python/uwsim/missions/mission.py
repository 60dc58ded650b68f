"""The interface of a mission: steps that fly it, and a state from which another process can continue it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol, runtime_checkable

from uwsim.missions.steps import Steps


class SteppedMission(Protocol):
    """A mission whose steps fly it. A generator function is the short form of one that cannot be restored."""

    def steps(self) -> Steps[Any]:
        """Return the steps, which yield waits; they return the mission's result."""


class Mission(SteppedMission, Protocol):
    """A mission that a survey can fly; AdaptiveLawnMower is one."""

    @property
    def progress(self) -> float:
        """Share of the mission that has been flown, 0..1."""

    def run(self) -> str:
        """Fly all steps by a clock that can wait; return why it ended."""


@runtime_checkable
class ResumableMission(Protocol):
    """A mission that another process can continue. Any other mission is continued by flying it again."""

    def save(self) -> dict[str, Any]:
        """Return, as JSON values, everything that the rest of the mission depends on apart from vehicle and clock.

        Called while its steps are in a `yield`: their further actions must follow from this state.
        """

    def restore(self, state: Mapping[str, Any]) -> None:
        """Continue from the result of `save`: `steps` continue as if that `yield` had just ended.

        Raises ValueError.
        """
