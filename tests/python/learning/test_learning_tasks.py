"""Each task is solvable: a simple pilot that knows the true state solves it and earns more than an idle one."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest

from uwsim.base.axes import AXES
from uwsim.learning.baselines import BASELINES
from uwsim.learning.episodes import Episodes
from uwsim.learning.motion import Motion
from uwsim.learning.options import EpisodeOptions
from uwsim.learning.task import Task
from uwsim.learning.tasks import (
    TASKS,
    Coverage,
    Docking,
    GatePassing,
    PipelineFollowing,
    StationKeeping,
    TetheredReturn,
    Waypoint,
)

SEEDS = range(2)
Target = Callable[[Any, Motion], tuple[Any, Any]]
"""A function from the task and the motion to target positions (n, 3) and headings (n, 2)."""

EAST = np.array([1.0, 0.0])


class Pilot:
    """Proportional control towards a target, with damping, keeping the vehicle level."""

    def __init__(self, episodes: Episodes, target: Target, gain: float = 0.6) -> None:
        self.episodes, self.target, self.gain = episodes, target, gain

    def __call__(self, observation: Any) -> Any:
        now, task = self.episodes.motion, self.episodes.task
        place_m, heading = self.target(task, now)
        ahead = np.zeros((self.episodes.n, 3))
        ahead[:, :2] = heading
        efforts = np.zeros((self.episodes.n, len(AXES)))
        efforts[:, :3] = self.gain * now.towards(place_m) - 0.8 * now.velocity_body[:, :3]
        efforts[:, 3:] = -0.3 * now.velocity_body[:, 3:]
        efforts[:, 3] -= now.up_body[:, 1]
        efforts[:, 4] += now.up_body[:, 0]
        efforts[:, 5] += np.arctan2(now.in_body(ahead)[:, 1], now.in_body(ahead)[:, 0])
        return np.clip(efforts, -1.0, 1.0)[:, task.columns]


class Flown(NamedTuple):
    """An episode per seed: sums of rewards (n,), numbers of steps (n,), figures (steps, n), NaN after the end."""

    total: Any
    steps: Any
    figures: dict[str, Any]


def fly(episodes: Episodes, policy: Callable[[Any], Any]) -> Flown:
    for member, seed in enumerate(SEEDS):
        episodes.seed(member, seed)
    observation, flying, rows = episodes.begin(np.ones(episodes.n, np.bool_)), np.ones(episodes.n, np.bool_), []
    total, steps, ended = np.zeros(episodes.n), np.zeros(episodes.n, np.intp), np.zeros(episodes.n, np.bool_)
    while flying.any():
        outcome = episodes.step(policy(observation), ended if ended.any() else None)  # ended ones fly on, uncounted
        observation = outcome.observation
        total[flying] += outcome.reward[flying]
        steps[flying] += 1
        rows.append({name: np.where(flying, values, np.nan) for name, values in outcome.figures.items()})
        ended = outcome.terminated | outcome.truncated
        flying &= ~ended
    return Flown(total, steps, {name: np.array([row[name] for row in rows]) for name in rows[0]})


@cache
def flown(kind: type[Task], target: Target | None, gain: float = 0.6) -> Flown:
    episodes = Episodes(kind, len(SEEDS), EpisodeOptions(threads=1))
    still = np.zeros((len(SEEDS), len(kind.axes)))
    pilot = Pilot(episodes, target, gain) if target is not None else lambda observation: still
    return fly(episodes, pilot)


def station(task: StationKeeping, now: Motion) -> tuple[Any, Any]:
    return task.place_m, EAST


def waypoint(task: Waypoint, now: Motion) -> tuple[Any, Any]:
    return task._places_m, EAST


def dock(task: Docking, now: Motion) -> tuple[Any, Any]:
    """Return a point in front of the dock until the dock is straight behind, to keep clear of the posts."""
    aside = np.linalg.norm((now.position_world_m - task._dock_m)[:, 1:], axis=1)
    wait_m = np.where(aside > 0.3, np.maximum(now.position_world_m[:, 0], 3.0), 0.0)
    return task._dock_m + wait_m[:, None] * task._ahead, EAST


def gate(task: GatePassing, now: Motion) -> tuple[Any, Any]:
    aside = np.linalg.norm((now.position_world_m - task._middle_m)[:, 1:], axis=1)
    return task._middle_m + np.where(aside > 0.4, -4.0, 3.0)[:, None] * task._through, EAST


def pipeline(task: PipelineFollowing, now: Motion) -> tuple[Any, Any]:
    along_m, _ = task._track.nearest(now.position_world_m[:, :2])
    points, direction = task._track.at(np.minimum(along_m + 2.0, task._track.length_m))
    return np.column_stack([points, task.batch.world.height_at(points) + 3.0]), direction


@cache
def round_the_pile(sides: tuple[float, float]) -> Target:
    """Return a target that passes the pile on one side on the way out, and on one on the way back: 1 is north."""

    def target(task: TetheredReturn, now: Motion) -> tuple[Any, Any]:
        place_m, x_m = task._next_m().copy(), now.position_world_m[:, 0]
        beyond = np.where(task._returns, x_m > -1.5, x_m < 1.5)
        side = np.where(task._returns, sides[1], sides[0])
        aside = np.column_stack([np.where(task._returns, x_m - 1.5, x_m + 1.5), 2.2 * side, place_m[:, 2]])
        return np.where(beyond[:, None], aside, place_m), EAST

    return target


def lanes() -> Target:
    """Return a target that flies lanes to and fro, 4 m apart; the sonar looks about 2 m ahead."""
    ends = np.array(
        [(x, y) for k, y in enumerate((-8.0, -4.0, 0.0, 4.0, 8.0)) for x in ((-12.5, 9.0)[:: 1 - 2 * (k % 2)])]
    )
    at = np.zeros(len(SEEDS), np.intp)

    def target(task: Coverage, now: Motion) -> tuple[Any, Any]:
        near = np.linalg.norm(now.position_world_m[:, :2] - ends[at], axis=1) < 1.0
        at[near] = np.minimum(at[near] + 1, len(ends) - 1)
        return np.column_stack([ends[at], np.full(len(at), -3.5)]), EAST

    return target


@pytest.mark.parametrize(
    ("kind", "target"),
    [
        (Waypoint, waypoint),
        (Docking, dock),
        (GatePassing, gate),
        (PipelineFollowing, pipeline),
        (Coverage, lanes()),
        (TetheredReturn, round_the_pile((1.0, 1.0))),
    ],
    ids=lambda value: getattr(value, "__name__", ""),
)
def test_a_pilot_does_the_task(kind: type[Task], target: Target) -> None:
    done, idle = flown(kind, target), flown(kind, None)
    last = [done.figures["success"][done.steps[k] - 1, k] for k in range(len(SEEDS))]
    assert last == [1.0] * len(SEEDS)
    assert (done.total > idle.total + 5.0).all()


def test_a_station_is_kept() -> None:
    kept, idle = flown(StationKeeping, station, gain=3.0), flown(StationKeeping, None)
    assert (kept.total > 200.0).all()
    assert (kept.total > 2.0 * idle.total).all()
    assert kept.steps.tolist() == [400] * len(SEEDS)


def test_a_return_on_the_other_side_of_the_pile_leaves_a_turn() -> None:
    with_care, without = (flown(TetheredReturn, round_the_pile(sides)) for sides in ((1.0, 1.0), (1.0, -1.0)))
    assert (with_care.total > without.total + 15.0).all()
    assert [abs(without.figures["turns"][without.steps[k] - 1, k]) for k in range(len(SEEDS))] == [1.0] * len(SEEDS)


@pytest.mark.parametrize("name", BASELINES)
def test_a_baseline_that_sees_only_observations_does_the_task(name: str) -> None:
    """So that nothing in it has to be known that is not observed."""
    episodes = Episodes(TASKS[name], len(SEEDS), EpisodeOptions(threads=1, normalise=False))
    done = fly(episodes, BASELINES[name])
    assert [done.figures["success"][done.steps[k] - 1, k] for k in range(len(SEEDS))] == [1.0] * len(SEEDS)
    idle = fly(episodes, lambda observation: np.zeros((len(SEEDS), 5)))
    assert (done.total > idle.total + 10.0).all()
    assert not idle.figures["success"].any()
