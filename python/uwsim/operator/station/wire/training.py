"""Requests and responses of the station's services for exercises, plans and notes; see `messages`."""

from __future__ import annotations

from typing import Literal

from uwsim.channels.authority.rights import AidKind
from uwsim.operator.station.wire.messages import Message


class GoalState(Message):
    """A goal of an exercise. share: the fraction achieved, 0 to 1."""

    title: str
    points: float
    share: float


class BrokenLimit(Message):
    """A broken limit of an exercise, and the points that it cost. title: the limit in English."""

    title: str
    kind: str
    cost: float
    time_s: float


class AidState(Message):
    """An aid that the exercise allows, or that was used, and the points that it cost."""

    kind: AidKind
    is_allowed: bool
    used_s: float
    cost_per_s: float
    cost: float


class ExerciseState(Message):
    """The state of an exercise. points: the maximum; lost: deducted; has_sheet: whether an attempt's sheet exists.

    has_begun: false until the pilot begins the attempt. invalid_because: why the score is not valid, or "". name: of a
    packaged exercise, or "". next_name, next_title: of the one that the pilot may start after it, or "".
    """

    success: Literal[True]
    name: str
    title: str
    next_name: str
    next_title: str
    brief: str
    time_s: float
    limit_s: float
    score: float
    points: float
    pass_points: float
    lost: float
    attempt: int
    has_begun: bool
    is_valid: bool
    invalid_because: str
    aids: list[AidState]
    is_over: bool
    has_passed: bool
    ended_because: str
    goals: list[GoalState]
    broken: list[BrokenLimit]
    has_sheet: bool
    error: str


# The chart


class PlanRequest(Message):
    """A request about a plan. action: report, lanes, save, fly or stop. points_m: x, y, z in odom. name: the file's."""

    action: str
    vehicle: str | None = None
    points_m: list[list[float]] | None = None
    speed_m_s: float | None = None
    name: str | None = None


class PlanState(Message):
    """The state of the plan. reached: the number of the last waypoint reached.

    points_m, speed_m_s: of the scenario's survey, in the answer about its lanes.
    """

    success: Literal[True]
    message: str
    is_flying: bool
    reached: int
    ended_because: str
    points_m: list[list[float]] | None = None
    speed_m_s: float | None = None


# Inspection


class NotesRequest(Message):
    """A request about notes. action: list, add or comment. view: a camera's, to add a picture.

    place: view or vehicle.
    """

    action: str
    vehicle: str | None = None
    text: str | None = None
    category: str | None = None
    place: str | None = None
    view: str | None = None


class NoteState(Message):
    """A note. position_m: in odom, null if unknown. picture: file name, or ""."""

    number: int
    time_s: float
    vehicle: str
    category: str
    text: str
    position_m: list[float] | None
    picture: str


class NotesState(Message):
    """The notes of the run so far, and the comment shown in pictures."""

    success: Literal[True]
    message: str
    comment: str
    notes: list[NoteState]
