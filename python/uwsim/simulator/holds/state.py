"""The saved state of a vehicle's holds."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, FiniteFloat, NonNegativeInt

from uwsim.base.saved_state import State, Tick

HoldName = Literal["heading", "depth", "altitude", "position", "speed"]
Effort = Annotated[float, Field(ge=-1, le=1)]


class HoldsState(State):
    """Saved holds. targets: targets of the active holds; None while the stick steers or the vehicle brakes.

    braking: the tick at which each hold's stick was let go. memory: the Controller's state, once it has started.
    efforts: its last efforts.
    """

    targets: dict[HoldName, list[FiniteFloat] | None]
    braking: dict[HoldName, Tick]
    silent: dict[str, NonNegativeInt]
    stick: Annotated[list[Effort], Field(min_length=6, max_length=6)]
    efforts: Annotated[list[FiniteFloat], Field(min_length=6, max_length=6)]
    memory: Annotated[list[FiniteFloat], Field(min_length=25, max_length=25)] | None
    note: str
    next_control: Tick
