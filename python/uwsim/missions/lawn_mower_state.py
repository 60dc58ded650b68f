"""The state of an adaptive lawn-mower, as plain data from which another process can continue."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Literal

from annotated_types import Ge

from uwsim.missions.heights import HeightState

LegName = Literal["undock", "approach", "transit", "tilt", "turn", "abreast", "mow"]


@dataclass(frozen=True)
class LegStart:
    """Time and pose at the beginning of a leg."""

    time_s: float
    position_world_m: tuple[float, float, float]
    yaw_rad: float


@dataclass(frozen=True)
class LaneEnd:
    """The end of a lane: how much of it was flown, and why no more; "" if it was flown to its end."""

    flown_m: Annotated[float, Ge(0)]
    because: str


@dataclass(slots=True)
class MowerState:
    """A mission's progress.

    lanes_near_m: position at the start of the mission, which determines the order of the lanes. lane: index of the
    current lane. leg: the leg being flown for that lane. leg_start: None until the leg has begun. along_m: current
    distance along the lane. furthest_m: the largest along_m so far, reached at furthest_s. skipped: number of lanes
    skipped as unreachable. legs: number of legs begun for the current lane. radius_m: for a vehicle without
    sway, the radius of its curves; 0 before the first. reached: how far along a curve it is, in points. entry_m: where
    on the current lane it began to fly along it; None before that. ended: the lanes before the current one. stops: for
    a vehicle without sway, whether it has slipped too far in a curve, and since then stops to turn. drift_rad: its mean
    drift since then, from its heading to its course.
    """

    lanes_near_m: tuple[float, float]
    leg: LegName
    lane: Annotated[int, Ge(0)] = 0
    leg_start: LegStart | None = None
    along_m: float = 0.0
    furthest_m: float = 0.0
    furthest_s: float = 0.0
    skipped: Annotated[int, Ge(0)] = 0
    legs: Annotated[int, Ge(0)] = 0
    radius_m: Annotated[float, Ge(0)] = 0.0
    reached: Annotated[int, Ge(0)] = 0
    entry_m: float | None = None
    ended: list[LaneEnd] = field(default_factory=list)
    stops: bool = False
    drift_rad: float = 0.0


@dataclass
class SavedMission:
    """A saved lawn-mower: its own state, plus that of its pilot, obstacle memory, shoal chart and heights."""

    mower: MowerState
    autopilot: tuple[float, ...]
    lookout: list[tuple[float, float, float]]
    shoals: list[tuple[int, int]] = field(default_factory=list)
    heights: HeightState = field(default_factory=HeightState)
