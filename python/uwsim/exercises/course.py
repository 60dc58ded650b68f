"""Course: an exercise in progress in a simulator. It judges goals and limits, triggers events, and keeps the score."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from uwsim.base.agenda import Rank, next_tick
from uwsim.base.commands import COMMANDS, bound_command
from uwsim.base.texts.value_words import details, with_details, words
from uwsim.channels.authority.rights import AidKind
from uwsim.exercises.conduct import Conduct, OutsideAct
from uwsim.exercises.exercise import Event, Exercise
from uwsim.exercises.goal import Progress
from uwsim.exercises.limits import AGAIN_S, LimitModel
from uwsim.exercises.moment import Moment
from uwsim.simulator.simulator import Simulator

PERIOD_S = 0.1
Command = Callable[[str, Mapping[str, Any]], Any]
"""Issues a command by name, with its arguments."""


@dataclass
class Happening:
    """An entry in the course's log. time_s: time since the beginning. kind: goal, limit, event or end.

    of: the kind of a limit.
    """

    time_s: float
    kind: str
    text: str
    points: float = 0.0
    position_world_m: tuple[float, ...] = ()
    of: str = ""


@dataclass
class _State:
    """Everything that changes in an attempt."""

    progress: list[Progress]
    begun_tick: int
    last_s: float = -1.0
    collisions: int = 0
    broken_s: list[float] = field(default_factory=list)
    is_broken: list[bool] = field(default_factory=list)
    done: set[int] = field(default_factory=set)
    log: list[Happening] = field(default_factory=list)
    track: list[tuple[float, ...]] = field(default_factory=list)
    lost: float = 0.0
    over_s: float | None = None
    ended_because: str = ""


class Course:
    """An exercise in progress.

    sim: a simulator of the exercise's scenario. command: issues the commands of events; by default directly, without a
    live simulator. outsider: who else could have issued commands that change the world. aids: returns the aids in use
    that the simulator does not know. Call `attach` for a simulator stepped by a mission; with a LiveSimulator call
    `judge` every PERIOD_S.

    attempt: the number of the attempt, from 1. has_begun: whether it has begun; until then, nothing is judged. conduct:
    outside acts and aids in this attempt.
    """

    def __init__(
        self,
        exercise: Exercise,
        sim: Simulator,
        command: Command | None = None,
        *,
        outsider: str = "the pilot's program",
        aids: Callable[[], Collection[AidKind]] = tuple,
    ) -> None:
        self.exercise, self.sim = exercise, sim
        self._vehicle = sim.rov
        self._command = command or (lambda name, arguments: bound_command(name, arguments)(sim))
        self._outsider, self._other_aids = outsider, aids
        self._issues = False  # while the course itself issues a command
        self.due_tick = sim.tick
        self.attempt = 1
        self.restart()
        sim.journal.listen(self, efforts=False)

    def __repr__(self) -> str:
        return f"<Course '{self.exercise.title}' of {self.sim!r}>"

    @staticmethod
    def require_events(exercise: Exercise, sim: Simulator) -> None:
        """Try all events on a simulator, then restore its state.

        Raises ValueError if an event cannot happen, or if the scenario lacks what a goal or a limit needs.
        """
        for index, goal in enumerate(exercise.goals):
            try:
                goal.require(sim)
            except ValueError as error:
                raise ValueError(f"goals[{index}]: {error}") from None
        for index, limit in enumerate(exercise.limits):
            try:
                limit.require(sim)
            except ValueError as error:
                raise ValueError(f"limits[{index}]: {error}") from None
        for index, event in enumerate(exercise.events):
            if event.command == "end_fault":
                continue  # the fault begins later
            state = sim.save_state()
            try:
                bound_command(event.command, event.arguments)(sim)
            except (ValueError, LookupError, TypeError) as error:
                raise ValueError(f"events[{index}]: {error}") from None
            finally:
                sim.restore_state(state)

    def restart(self) -> None:
        """Begin at the current tick."""
        self.has_begun, self.conduct = True, Conduct(self.exercise.aids)
        self._now = _State([goal.begun() for goal in self.exercise.goals], self.sim.tick)
        limits = len(self.exercise.limits)
        self._now.broken_s, self._now.is_broken = [-math.inf] * limits, [False] * limits

    def wait_to_begin(self, attempt: int) -> None:
        """Judge nothing until `restart` begins an attempt with this number."""
        self.restart()
        self.has_begun, self.attempt = False, attempt

    def concluded(self, because: str) -> Course:
        """Return a copy that keeps the result of the present attempt, which ends as last judged if it is not over."""
        found = copy.copy(self)
        found._now = copy.deepcopy(self._now)
        if not found.is_over:
            found._end(max(self._now.last_s, 0.0), because)
        return found

    def attach(self) -> Course:
        """Start judging whenever due while the simulator steps; return self."""
        self.sim.agenda.add(self, Rank.READING, lambda tick: self.judge(), jump=self._jump)
        return self

    def detach(self) -> None:
        """Stop judging, and hearing commands."""
        self.sim.agenda.remove(self)
        self.sim.journal.detach(self)

    def _jump(self, tick: int) -> None:
        self.due_tick = tick

    @property
    def time_s(self) -> float:
        """Simulated seconds since the beginning, up to the end."""
        if self._now.over_s is not None:
            return self._now.over_s
        if not self.has_begun:
            return 0.0
        return (self.sim.tick - self._now.begun_tick) * self.sim.step_s

    @property
    def begun_tick(self) -> int:
        """The simulator's tick at which the attempt began."""
        return self._now.begun_tick

    @property
    def is_over(self) -> bool:
        """True once the score is final."""
        return self._now.over_s is not None

    @property
    def score(self) -> float:
        """The points so far, not below 0."""
        gained = sum(g.points * p.share for g, p in zip(self.exercise.goals, self._now.progress, strict=True))
        return max(gained - self._now.lost - self.conduct.cost, 0.0)

    @property
    def has_passed(self) -> bool:
        """True if the score is valid, and high enough to pass."""
        return not self.conduct.invalid_because and self.score >= self.exercise.pass_points

    @property
    def has_jumped_back(self) -> bool:
        """True if simulated time is before the beginning, or before what was judged last."""
        return self.sim.tick < self._now.begun_tick or self._elapsed_s < self._now.last_s - 1e-9

    def judge(self) -> None:
        """Judge the current moment. Called every PERIOD_S; a jump back to before the beginning restarts it."""
        sim, now = self.sim, self._now
        period_ns, step_ns = round(PERIOD_S * 1e9), round(sim.step_s * 1e9)
        self.due_tick = next_tick(sim.tick, period_ns, step_ns)
        if not self.has_begun:
            return
        if self.has_jumped_back:
            self.restart()
            now = self._now
        if self.is_over:
            return
        moment = Moment.of(sim, self._vehicle, self._elapsed_s)
        self._let_happen(moment)
        self._judge_goals(moment)
        self._judge_limits(moment, now.collisions if now.last_s >= 0.0 else moment.collisions)
        for aid in self._aids_in_use():
            self.conduct.note_aid(aid, moment.time_s - max(now.last_s, 0.0))
        now.last_s, now.collisions = moment.time_s, moment.collisions
        now.track.append((moment.time_s, *moment.position_world_m.tolist(), moment.yaw_rad, moment.altitude_m))
        if self.is_over:
            return
        if all(one.is_met for one in now.progress):
            self._end(moment.time_s, "all goals are met")
        elif moment.time_s >= self.exercise.time_s - 1e-9:
            self._end(self.exercise.time_s, "the time is over")

    @property
    def _elapsed_s(self) -> float:
        return (self.sim.tick - self._now.begun_tick) * self.sim.step_s

    def finish(self, because: str) -> None:
        """End the exercise now, if it has not ended."""
        if not self.is_over:
            self._end(self._elapsed_s, because)

    def _end(self, time_s: float, because: str) -> None:
        self._now.over_s, self._now.ended_because = time_s, because
        self._now.log.append(Happening(time_s, "end", because))

    def _aids_in_use(self) -> set[AidKind]:
        holds = self._vehicle.holds
        own: set[AidKind] = {"hold"} if holds is not None and holds.has_control else set()
        return own | set(self._other_aids())

    def commanded(self, name: str, arguments: dict[str, Any]) -> None:
        """Note a command, unless it is an event of the exercise; see CommandObserver."""
        if name not in COMMANDS or self._issues or self.is_over or not self.has_begun:
            return
        text = with_details(words(name), details(arguments))[:200]
        if COMMANDS[name].changes_world:
            self.note_outside(text, self._outsider, changed=True)
        else:
            self.conduct.note_command(self._elapsed_s, name, text)

    def note_outside(self, text: str, by: str, *, changed: bool) -> None:
        """Note an act of another than the pilot. changed: whether it changed the world."""
        if not self.is_over and self.has_begun:
            self.conduct.note(OutsideAct(self._elapsed_s, by, text, changed))

    def _let_happen(self, moment: Moment) -> None:
        for index, event in enumerate(self.exercise.events):
            if index not in self._now.done and self._is_due(event, moment):
                self._now.done.add(index)
                self._note(moment, "event", event.note or with_details(words(event.command), details(event.arguments)))
                self._issues = True
                try:
                    self._command(event.command, event.arguments)
                finally:
                    self._issues = False

    def _is_due(self, event: Event, moment: Moment) -> bool:
        if event.at_s is not None:
            return moment.time_s >= event.at_s - 1e-9
        if event.near is not None:
            return moment.distance_m(event.near.position_m) <= event.near.within_m
        return event.after is not None and self._are_met([event.after])

    def _are_met(self, names: Collection[str]) -> bool:
        goals = zip(self.exercise.goals, self._now.progress, strict=True)
        return all(one.is_met for goal, one in goals if goal.name in names)

    def _judge_goals(self, moment: Moment) -> None:
        for goal, one in zip(self.exercise.goals, self._now.progress, strict=True):
            if one.is_met or not self._are_met(goal.earlier):
                continue
            one.judge(moment, PERIOD_S)
            if one.is_met:
                self._note(moment, "goal", goal.title, goal.points * one.share)

    def _judge_limits(self, moment: Moment, collisions_before: int) -> None:
        now = self._now
        for index, limit in enumerate(self.exercise.limits):
            was_broken, now.is_broken[index] = now.is_broken[index], limit.is_broken(moment, collisions_before)
            if not now.is_broken[index]:
                continue
            since_s, now.broken_s[index] = moment.time_s - now.broken_s[index], moment.time_s
            if was_broken or since_s < AGAIN_S:
                continue
            now.lost += limit.cost
            self._note(moment, "limit", limit.title, -limit.cost, limit.kind)
            if limit.ends:
                self._end(moment.time_s, f"a limit is broken: {limit.title}")

    def _note(self, moment: Moment, kind: str, text: str, points: float = 0.0, of: str = "") -> None:
        place = tuple(moment.position_world_m.tolist())
        self._now.log.append(Happening(moment.time_s, kind, text, points, place, of))

    def state(self) -> dict[str, Any]:
        """Return the state that the pilot may see, without events and positions. All values are of JSON types."""
        now = self._now
        goals = zip(self.exercise.goals, now.progress, strict=True)
        return {
            "title": self.exercise.title,
            "brief": " ".join(self.exercise.brief.split()),
            "time_s": self.time_s,
            "limit_s": self.exercise.time_s,
            "score": self.score,
            "points": self.exercise.points,
            "pass_points": self.exercise.pass_points,
            "lost": now.lost + self.conduct.cost,
            "attempt": self.attempt,
            "has_begun": self.has_begun,
            "is_valid": not self.conduct.invalid_because,
            "invalid_because": self.conduct.invalid_because,
            "aids": self.conduct.aids(),
            "is_over": self.is_over,
            "has_passed": self.has_passed,
            "ended_because": now.ended_because,
            "goals": [{"title": g.title, "points": g.points, "share": p.share} for g, p in goals],
            "broken": [
                {"title": h.text, "kind": h.of, "cost": -h.points, "time_s": h.time_s}
                for h in now.log
                if h.kind == "limit"
            ],
        }

    def sheet(self) -> dict[str, Any]:
        """Return the score sheet: the state, the log, and the size of the errors. All values are of JSON types."""
        goals = [
            {
                "name": goal.name, "title": goal.title, "kind": goal.kind, "points": goal.points, "share": one.share,
                "scored": goal.points * one.share, "places_m": [list(place) for place in goal.places_m],
                **_error_figures(one.errors_m),
            }
            for goal, one in zip(self.exercise.goals, self._now.progress, strict=True)
        ]  # fmt: skip
        log = [
            {"time_s": h.time_s, "kind": h.kind, "text": h.text, "points": h.points,
             "position_world_m": list(h.position_world_m)}
            for h in self._now.log
        ]  # fmt: skip
        return {
            **self.state(), "seed": self.sim.seed, "scenario": self.exercise.scenario,
            "lag_s": self.exercise.lag_s, "goals": goals,
            "limits": [self._limit_figures(limit) for limit in self.exercise.limits], "log": log,
            **self.conduct.listed(),
        }  # fmt: skip

    def _limit_figures(self, limit: LimitModel) -> dict[str, Any]:
        times = sum(h.kind == "limit" and h.text == limit.title for h in self._now.log)
        return {"title": limit.title, "kind": limit.kind, "cost": limit.cost, "ends": limit.ends, "broken": times}

    @property
    def track(self) -> np.ndarray[Any, np.dtype[np.float64]]:
        """The true track, (n, 6): time [s], x, y, z [m], yaw [rad], altitude [m]."""
        return np.array(self._now.track, np.float64).reshape(-1, 6)

    def errors(self) -> dict[str, tuple[Any, Any]]:
        """Return times [s] and errors [m], (n,) each, by title of the goals that require a value to be held."""
        goals = zip(self.exercise.goals, self._now.progress, strict=True)
        return {g.title: (np.array(p.times_s), np.array(p.errors_m)) for g, p in goals if len(p.errors_m) > 1}


def _error_figures(errors_m: list[float]) -> dict[str, float]:
    if not errors_m:
        return {}
    return {"error_mean_m": float(np.mean(errors_m)), "error_max_m": float(np.max(errors_m))}
