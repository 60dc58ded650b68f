"""The kinds of goals: each is a model with its YAML keys, and a Progress that judges moments 0.1 s apart."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, model_validator

from uwsim.exercises.moment import Floats, Moment
from uwsim.scenario.spec.fields import Degrees, InRange, Metres, Model, Name, Point2, Point3, broken

Duration = Annotated[float, InRange(0.1, 1e5, "s")]
Within = Annotated[float, InRange(0.01, 1000, "m")]
Points = Annotated[float, InRange(0, 1000)]
NoteCategory = Literal["observation", "defect", "leak", "debris", "growth"]
STATIONS_M = 0.5  # spacing of the points of a path that must be passed
PASSED = 0.95  # share of a path or an area that counts as complete


class Progress(ABC):
    """How much of a goal has been met. share: in [0, 1]. errors_m: deviations from the value to be held, if any."""

    def __init__(self) -> None:
        self.share = 0.0
        self.errors_m: list[float] = []
        self.times_s: list[float] = []

    @property
    def is_met(self) -> bool:
        """True once the goal has been met in full."""
        return self.share >= 1.0

    @abstractmethod
    def judge(self, moment: Moment, period_s: float) -> None:
        """Judge the next moment, period_s after the last."""

    def note(self, time_s: float, error_m: float) -> None:
        """Record an error for the debriefing."""
        self.times_s.append(time_s)
        self.errors_m.append(error_m)


class GoalModel(Model):
    """The keys that all goals share.

    name: used in `after`. title: shown to the pilot. points: awarded for meeting it. after: the name of a goal that
    must be met before this one counts.
    """

    name: Name
    title: str = Field(min_length=1, max_length=120)
    points: Points = 10.0
    after: Name | None = None

    def begun(self) -> Progress:
        """Return the goal's progress at the beginning."""
        raise NotImplementedError


class Reach(GoalModel):
    """Reach a position.

    position_m: position in the world. within_m: distance at which it counts as reached.
    """

    kind: Literal["reach"]
    position_m: Point3
    within_m: Within = 1.0

    def begun(self) -> Progress:
        """See GoalModel."""
        return _Reaching(self)


class Pass(GoalModel):
    """Pass through an opening, such as a gate.

    position_m: its centre. heading_deg: the direction of passage, counter-clockwise from east. within_m: its radius.
    """

    kind: Literal["pass"]
    position_m: Point3
    heading_deg: Degrees
    within_m: Within = 1.0

    def begun(self) -> Progress:
        """See GoalModel."""
        return _Passing(self)


class Follow(GoalModel):
    """Follow a path from its first point to its last.

    points_m: its corners. within_m: allowed distance from the path. The goal's share is the share of the path's length
    passed in order: a pilot who leaves the path must return to the point of departure.
    """

    kind: Literal["follow"]
    points_m: list[Point3] = Field(min_length=2, max_length=1000)
    within_m: Within = 1.0

    def begun(self) -> Progress:
        """See GoalModel."""
        return _Following(self)


class LookAt(GoalModel):
    """Keep a place in view of one of the vehicle's cameras.

    position_m: position in the world. within_m: distance from the camera. for_s: uninterrupted time. cameras: names, by
    default all that move with the vehicle's body. clear_m: surfaces this close to the place do not count as hiding it.
    """

    kind: Literal["look_at"]
    position_m: Point3
    within_m: Within = 3.0
    for_s: Duration = 2.0
    cameras: list[Name] = Field(default_factory=list)
    clear_m: Annotated[float, InRange(0, 10, "m")] = 0.3

    def begun(self) -> Progress:
        """See GoalModel."""
        return _Looking(self)


class Hold(GoalModel):
    """Hold a position, a depth or a heading for some time without interruption.

    position_m: position in the world; within_m: distance from it. depth_m: positive down; within_m applies.
    heading_deg: counter-clockwise from east; within_deg: difference from it. for_s: how long.
    """

    kind: Literal["hold"]
    position_m: Point3 | None = None
    depth_m: Metres | None = None
    heading_deg: Degrees | None = None
    within_m: Within = 0.5
    within_deg: Annotated[float, InRange(0.1, 180, "deg")] = 10.0
    for_s: Duration = 20.0

    @model_validator(mode="after")
    def _has_a_limit(self) -> Hold:
        if self.position_m is None and self.depth_m is None and self.heading_deg is None:
            raise broken("must have at least one of position_m, depth_m and heading_deg")
        return self

    def begun(self) -> Progress:
        """See GoalModel."""
        return _Holding(self)


class MapArea(GoalModel):
    """Sweep an area of the bed with the first multibeam sonar, which is read once per second.

    area_m: a polygon, x and y. cell_m: edge length of the cells into which it is divided. share: fraction of the cells
    that must have returned an echo for full points.
    """

    kind: Literal["map"]
    area_m: list[Point2] = Field(min_length=3, max_length=1000)
    cell_m: Within = 1.0
    share: Annotated[float, InRange(0.01, 1)] = 0.9

    def begun(self) -> Progress:
        """See GoalModel."""
        return _Mapping(self)


class Report(GoalModel):
    """Report what is at a place by writing a note, either at the station or with the command `note`.

    position_m: position in the world. within_m: how close to it the note must be placed. category: the note's category.
    """

    kind: Literal["report"]
    position_m: Point3
    within_m: Within = 3.0
    category: NoteCategory = "defect"

    def begun(self) -> Progress:
        """See GoalModel."""
        return _Reporting(self)


Goal = Annotated[Reach | Pass | Follow | LookAt | Hold | MapArea | Report, Field(discriminator="kind")]


class _Reaching(Progress):
    def __init__(self, goal: Reach) -> None:
        super().__init__()
        self._goal = goal

    def judge(self, moment: Moment, period_s: float) -> None:
        if moment.distance_m(self._goal.position_m) <= self._goal.within_m:
            self.share = 1.0


class _Passing(Progress):
    def __init__(self, goal: Pass) -> None:
        super().__init__()
        self._goal, self._before = goal, (0.0, np.zeros(3))
        heading = math.radians(goal.heading_deg)
        self._ahead = np.array([math.cos(heading), math.sin(heading), 0.0])
        self._has_before = False

    def judge(self, moment: Moment, period_s: float) -> None:
        offset = moment.position_world_m - np.array(self._goal.position_m)
        depth_m = float(offset @ self._ahead)
        (before_m, old), self._before = self._before, (depth_m, offset)
        if self._has_before and before_m < 0.0 <= depth_m:
            crossing = old + (offset - old) * (-before_m / (depth_m - before_m))
            error_m = float(np.linalg.norm(crossing))
            self.note(moment.time_s, error_m)
            if error_m <= self._goal.within_m:
                self.share = 1.0
        self._has_before = True


class _Following(Progress):
    def __init__(self, goal: Follow) -> None:
        super().__init__()
        self._within_m = goal.within_m
        self._stations, self._corners = _stations(goal.points_m), np.array(goal.points_m, np.float64)
        self._next = 0

    def judge(self, moment: Moment, period_s: float) -> None:
        away_m = np.linalg.norm(self._stations - moment.position_world_m, axis=1)
        while self._next < len(away_m) and away_m[self._next] <= self._within_m:
            self._next += 1
        if 0 < self._next < len(self._stations):
            self.note(moment.time_s, _distance_m(moment.position_world_m, self._corners))
        self.share = self._next / len(self._stations)


class _Looking(Progress):
    def __init__(self, goal: LookAt) -> None:
        super().__init__()
        self._goal, self._seen_s = goal, 0.0

    def judge(self, moment: Moment, period_s: float) -> None:
        self._seen_s = self._seen_s + period_s if self._is_in_view(moment) else 0.0
        self.share = max(self.share, min(self._seen_s / self._goal.for_s, 1.0))

    def _is_in_view(self, moment: Moment) -> bool:
        goal, place = self._goal, np.array(self._goal.position_m)
        if moment.distance_m(goal.position_m) > goal.within_m + 5.0:
            return False  # no camera is farther from the vehicle's centre
        names = goal.cameras or [name for name, one in moment.vehicle.cameras.items() if one.mount.follows == "body"]
        return any(self._sees(moment, moment.vehicle.cameras[name], place) for name in names)

    def _sees(self, moment: Moment, camera: Any, place: Floats) -> bool:
        world_from_camera = camera.world_from_camera
        eye = world_from_camera[:3, 3]
        ray = place - eye
        distance_m = float(np.linalg.norm(ray))
        if not camera.mount.on or not 1e-6 < distance_m <= self._goal.within_m:
            return False
        ahead, left, up = (world_from_camera[:3, :3].T @ ray).tolist()
        if ahead <= 0.0:
            return False
        half = math.tan(math.radians(0.5 * camera.mount.field_of_view_deg))
        if abs(left) > half * ahead or abs(up) > half * ahead * camera.mount.height / camera.mount.width:
            return False
        hit_m = float(moment.sim.scene.cast(eye[None], ray[None], distance_m).ranges_m[0])
        return hit_m >= distance_m - self._goal.clear_m


class _Holding(Progress):
    def __init__(self, goal: Hold) -> None:
        super().__init__()
        self._goal, self._kept_s = goal, 0.0
        self._is_first = True

    def judge(self, moment: Moment, period_s: float) -> None:
        error_m = self._error_m(moment)
        is_kept = error_m <= self._goal.within_m and self._turned_deg(moment) <= self._goal.within_deg
        if is_kept:
            self._is_first = False
        if not self._is_first:
            self.note(moment.time_s, error_m)
        self._kept_s = self._kept_s + period_s if is_kept else 0.0
        self.share = max(self.share, min(self._kept_s / self._goal.for_s, 1.0))

    def _error_m(self, moment: Moment) -> float:
        found = [0.0]
        if self._goal.position_m is not None:
            found.append(moment.distance_m(self._goal.position_m))
        if self._goal.depth_m is not None:
            found.append(abs(self._goal.depth_m + float(moment.position_world_m[2])))
        return max(found)

    def _turned_deg(self, moment: Moment) -> float:
        if self._goal.heading_deg is None:
            return 0.0
        return abs((math.degrees(moment.yaw_rad) - self._goal.heading_deg + 180.0) % 360.0 - 180.0)


class _Reporting(Progress):
    def __init__(self, goal: Report) -> None:
        super().__init__()
        self._goal = goal

    def judge(self, moment: Moment, period_s: float) -> None:
        away_m = [
            math.dist(place, self._goal.position_m)
            for note in moment.notes(self._goal.category)
            if (place := note.values["position_world_m"]) is not None
        ]
        if away_m and min(away_m) <= self._goal.within_m:
            self.note(moment.time_s, min(away_m))
            self.share = 1.0


class _Mapping(Progress):
    def __init__(self, goal: MapArea) -> None:
        super().__init__()
        self._goal = goal
        corners = np.array(goal.area_m)
        self._low = corners.min(axis=0)
        counts = np.ceil((corners.max(axis=0) - self._low) / goal.cell_m).astype(int)
        middles = self._low + goal.cell_m * (np.moveaxis(np.indices(tuple(counts)), 0, -1) + 0.5)
        self._wanted = inside(middles.reshape(-1, 2), corners).reshape(counts)
        self._seen = np.zeros_like(self._wanted)
        self._due_s = 0.0

    def judge(self, moment: Moment, period_s: float) -> None:
        if moment.time_s < self._due_s - 1e-6:
            return
        self._due_s = moment.time_s + 1.0
        ping = moment.vehicle.sonar.ping()
        world_from_sonar = ping.world_from_sonar
        echoes = ping.points_sonar_m[ping.valid] @ world_from_sonar[:3, :3].T + world_from_sonar[:3, 3]
        cells = np.floor((echoes[:, :2] - self._low) / self._goal.cell_m).astype(int)
        cells = cells[((cells >= 0) & (cells < self._seen.shape)).all(axis=1)]
        self._seen[cells[:, 0], cells[:, 1]] = True
        found = float((self._seen & self._wanted).sum()) / max(int(self._wanted.sum()), 1)
        self.share = min(found / self._goal.share, 1.0)


def _distance_m(point: Floats, corners: Floats) -> float:
    """Return the distance from a point (3,) to straight legs through corners (n, 3)."""
    starts, legs = corners[:-1], np.diff(corners, axis=0)
    along = np.einsum("ij,ij->i", point - starts, legs) / np.maximum(np.einsum("ij,ij->i", legs, legs), 1e-12)
    nearest = starts + np.clip(along, 0.0, 1.0)[:, None] * legs
    return float(np.linalg.norm(nearest - point, axis=1).min())


def _stations(corners: Sequence[Point3]) -> Floats:
    """Return points (n, 3) along straight legs, at most STATIONS_M apart."""
    found = [np.array(corners[0], np.float64)]
    for start, end in pairwise(corners):
        first, last = np.array(start), np.array(end)
        count = max(1, math.ceil(float(np.linalg.norm(last - first)) / STATIONS_M))
        found += [first + (last - first) * k / count for k in range(1, count + 1)]
    return np.array(found)


def inside(points: Floats, corners: Floats) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Return a mask (n,) of the points (n, 2) inside a polygon (m, 2), by the even-odd rule."""
    x, y = points.T
    inside = np.zeros(len(points), np.bool_)
    for (x0, y0), (x1, y1) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        if y0 != y1:
            inside ^= ((y0 > y) != (y1 > y)) & (x < (x1 - x0) * (y - y0) / (y1 - y0) + x0)
    return inside
