"""The mission interface: the steps that fly a mission."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

from uwsim.missions.steps import Steps

if TYPE_CHECKING:
    from typing_extensions import TypeVar

    R_co = TypeVar("R_co", covariant=True, default=Any)
else:
    from typing import TypeVar

    R_co = TypeVar("R_co", covariant=True)


class SteppedMission(Protocol[R_co]):
    """A mission flown by its steps, as a generator function is.

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
