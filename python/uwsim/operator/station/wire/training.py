"""Requests and responses of the station's services for exercises, the instructor, plans and notes; see `messages`."""

from __future__ import annotations

from typing import Any, Literal

from uwsim.channels.authority.rights import AidKind
from uwsim.operator.station.wire.messages import EventDetail, Message


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
    packaged exercise, or "". next_name, next_title: of the one that the pilot may start after it, or "". flight:
    the recording of the attempt that has ended, from its begin, or "".
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
    flight: str
    error: str


# The instructor


class Supervise(Message):
    """A request to become the instructor."""

    token: str


class Instruct(Message):
    """A request by the instructor. action, args: see docs/connections/station-wire.md."""

    action: str
    args: dict[str, Any] | None = None


class VehicleTruth(Message):
    """A vehicle's true state. is_stopped: whether all stop is set, paused or not."""

    name: str
    position_world_m: list[float]
    heading_deg: float
    speed_m_s: float
    altitude_m: float | None
    battery_percent: float
    collisions: int
    is_stopped: bool
    sensors: list[str]
    thrusters: list[str]
    cameras: list[str]


class SavedMoment(Message):
    """A moment to return to."""

    name: str
    time_s: float


class Instruction(Message):
    """An entry of the log of both sides. clock: wall-clock time, ISO 8601. by: "instructor", or the pilot's name."""

    time_s: float
    clock: str
    by: str
    action: str
    args: dict[str, Any]
    text: str
    details: list[EventDetail]


class FaultTime(Message):
    """When a fault began or begins. end_s: when it ended, or null. planned_end_s: when it is to end, null for never."""

    name: str
    kind: str
    size: str
    begin_s: float
    end_s: float | None
    planned_end_s: float | None


class Overview(Message):
    """The truth, for the instructor. exercise: an ExerciseState without `success`. log: newest first."""

    success: Literal[True]
    time_s: float
    vehicles: list[VehicleTruth]
    faults: list[str]
    fault_times: list[FaultTime]
    exercise: dict[str, Any] | None
    moments: list[SavedMoment]
    log: list[Instruction]


class ParameterList(Message):
    """All parameters. descriptions_json: as returned by /simulation/describe_parameters.

    visibility_m: how far one sees horizontally in each type of water.
    """

    success: Literal[True]
    descriptions_json: str
    visibility_m: dict[str, float]


class FaultField(Message):
    """A key of a kind of fault. part: the list in VehicleTruth of which it names an item, or "".

    width: the number of values. low, high: their bounds, or null. choices: the permitted values, or none for any.
    value: the one with which a form begins.
    """

    name: str
    meaning: str
    is_number: bool
    is_optional: bool
    width: int
    unit: str
    low: float | None
    high: float | None
    choices: list[Any]
    part: str
    value: Any


class FaultKind(Message):
    """A kind of fault that the instructor may inject, and its keys."""

    kind: str
    meaning: str
    fields: list[FaultField]


class FaultKinds(Message):
    """All kinds of faults, those of other packages last."""

    success: Literal[True]
    kinds: list[FaultKind]


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
