"""A single fault: its kind, start and end, and saved state."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import Field, FiniteFloat, NonNegativeInt

from uwsim.base.saved_state import State, Tick
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.fault import FaultModel, FaultSpec
from uwsim.scenario.spec.fields import Model


class _One(Model):
    faults: tuple[FaultSpec, ...]


def checked_fault(given: dict[str, Any]) -> FaultModel:
    """Validate a fault that does not come from a scenario file. Raises ScenarioError, a ValueError."""
    return validated(_One, {"faults": [given]}).faults[0]


class FaultState(State):
    """A saved fault. spec: a dict with the keys used in scenario files."""

    spec: dict[str, Any]
    vehicle: str
    begin_tick: Tick
    end_tick: Tick | None
    count: NonNegativeInt
    began_tick: Tick
    filled_tick: Tick
    water_kg: Annotated[FiniteFloat, Field(ge=0.0)]


@dataclass
class Fault:
    """A fault and its current state. count: how many times it has begun. water_kg: mass of water that it has let in."""

    name: str
    spec: FaultModel
    vehicle: str
    begin_tick: int
    end_tick: int | None = None  # None while inactive; NEVER: active until the end of the run
    count: int = 0
    began_tick: int = 0
    filled_tick: int = 0
    water_kg: float = 0.0

    @property
    def is_active(self) -> bool:
        """Whether the fault is active now."""
        return self.end_tick is not None

    def save(self) -> dict[str, Any]:
        """Return the fault's state as JSON values."""
        kept = {key: getattr(self, key) for key in FaultState.model_fields if key != "spec"}
        return {"spec": self.spec.model_dump(exclude_none=True), **kept}

    @staticmethod
    def restored(name: str, state: FaultState) -> Fault:
        """Build a fault from its saved state. Raises ValueError for an unknown kind of fault."""
        values = {key: getattr(state, key) for key in FaultState.model_fields if key != "spec"}
        return Fault(name, checked_fault(state.spec), **values)
