"""The state of an adaptive lawn-mower: plain data, from which another process can continue."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Literal

from annotated_types import Ge

LegName = Literal["undock", "approach", "transit", "tilt", "turn", "abreast", "mow"]


@dataclass(frozen=True)
class LegStart:
    """Time and pose at the beginning of a leg."""

    time_s: float
    position_world_m: tuple[float, float, float]
    yaw_rad: float


@dataclass(slots=True)
class MowerState:
    """The progress of a mission.

    lanes_near_m: where the mission began, which determines the order of lanes. lane: index of the present one. leg: the
    part of it being flown. leg_start: None before the leg has begun. along_m: distance along the lane. furthest_m: the
    largest such distance so far, reached at furthest_s. skipped: number of lanes that could not be reached.
    """

    lanes_near_m: tuple[float, float]
    leg: LegName
    lane: Annotated[int, Ge(0)] = 0
    leg_start: LegStart | None = None
    along_m: float = 0.0
    furthest_m: float = 0.0
    furthest_s: float = 0.0
    skipped: Annotated[int, Ge(0)] = 0


@dataclass
class SavedMission:
    """A saved lawn-mower: its state, its pilot's memory, the obstacle memory's echoes, the shoals' cells."""

    mower: MowerState
    autopilot: tuple[float, ...]
    lookout: list[tuple[float, float, float]]
    shoals: list[tuple[int, int]] = field(default_factory=list)
