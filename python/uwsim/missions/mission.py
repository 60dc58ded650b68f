"""The mission interface: the steps that fly a mission, and a saved state from which another process can continue it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from uwsim.missions.steps import Steps

if TYPE_CHECKING:
    from typing_extensions import TypeVar

    R_co = TypeVar("R_co", covariant=True, default=Any)
else:
    from typing import TypeVar

    R_co = TypeVar("R_co", covariant=True)


class SteppedMission(Protocol[R_co]):
    """A mission flown by its steps. A mission that need not be restored may simply be a generator function.

    R_co: the type of its result; by default any.
    """

    def steps(self) -> Steps[R_co]:
        """Return a generator of steps that yields waits and returns the mission's result."""


class Mission(SteppedMission[Any], Protocol):
    """A mission that a survey can fly, such as AdaptiveLawnMower."""

    @property
    def progress(self) -> float:
        """Fraction of the mission flown so far, 0..1."""

    def run(self) -> str:
        """Fly all steps with a clock that can wait; return why the mission ended."""


@runtime_checkable
class ResumableMission(Protocol):
    """A mission that another process can continue. Any other mission is resumed by flying it again from the start."""

    def save(self) -> dict[str, Any]:
        """Return, as JSON values, all state that the rest of the mission depends on, except that of vehicle and clock.

        Called while `steps` is suspended at a `yield`; everything the mission does afterwards must depend only on this
        state.
        """

    def restore(self, state: Mapping[str, Any]) -> None:
        """Load a state returned by `save`; `steps` then continues as if that `yield` had just returned.

        Raises ValueError for an invalid state.
        """
