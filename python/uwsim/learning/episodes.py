"""The engine behind all environments: starts and steps the episodes of a batch, and reports which have ended.

A single environment is a batch of one, so member i of a vector environment has bit-identical episodes to a single
environment with the same seed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from gymnasium.utils.seeding import np_random
from numpy.typing import NDArray

from uwsim.base.named import did_you_mean
from uwsim.batch import Batch
from uwsim.learning.checks import checked_efforts, checked_start, checked_verdict, require_observed, require_task
from uwsim.learning.eye import Eye, look
from uwsim.learning.motion import Motion, yaw_xyzw
from uwsim.learning.options import EpisodeOptions, checked_ranges, in_sonar_mode, require_effect
from uwsim.learning.scales import Scales
from uwsim.learning.task import Flags, Floats, Task, Verdict
from uwsim.learning.view import View
from uwsim.scenario import AnyScenario, Scenario, load
from uwsim.scenario.build.arm import link_specs

SEED_MAX = 2**63


@dataclass(frozen=True, eq=False)
class Outcome:
    """The outcome of a step, one row per member. figures: the values for `info`, keyed by name."""

    observation: Any
    reward: Floats
    terminated: Flags
    truncated: Flags
    figures: dict[str, NDArray[Any]]


class Episodes:
    """The episodes of n members of a task. Each member draws its episodes from its own random generator.

    Raises ValueError for a task that is incomplete, and wherever one of its methods returns invalid values.
    """

    def __init__(self, kind: type[Task], n: int, options: EpisodeOptions) -> None:
        require_task(kind)
        scenario = task_scenario(kind, options.scenario)
        if options.sonar_mode is not None:
            scenario = in_sonar_mode(scenario, kind, options.sonar_mode)
        self.batch = Batch(scenario, n=n, faults=options.faults, threads=options.threads)
        require_effect(self.batch.faults[0], kind, scenario, options.camera)
        self.task = kind(self.batch)
        if not hasattr(self.task, "columns"):
            raise ValueError(f"{kind.__name__}.__init__: must call super().__init__(batch, vehicle)")
        require_driven(self.task)
        self.n = n
        self.period_s = kind.period_s
        self.steps = round(kind.period_s / scenario.step_s)
        if abs(self.steps * scenario.step_s - kind.period_s) > 1e-9 or self.steps < 1:
            rule = f"the period of an action, {kind.period_s:g} s, must be a whole number of steps"
            raise ValueError(f"step_s = {scenario.step_s:g} s: {rule}")
        self.duration_s = kind.duration_s if options.duration_s is None else options.duration_s
        self.ranges = checked_ranges({**kind.randomize, **(options.randomize or {})}, scenario)
        self.eye = None if options.camera is None else Eye(self.batch, options)
        self.normalise = options.normalise
        self._space = self.task.observation_space
        self._scales = Scales(kind, self._space)
        self.observation_space = look(self._scales.space(self._space) if self.normalise else self._space, self.eye)
        self.action_space = self.task.action_space
        self.generators: list[np.random.Generator | None] = [None] * n
        self.generator_seeds: list[int] = [-1] * n
        self._seeds = list(self.batch.seeds)
        self.actions = np.zeros((n, len(kind.action_names())))
        self._fastest = fastest_joints(self.task)
        self._motion: Motion | None = None

    def __repr__(self) -> str:
        return f"<Episodes of {type(self.task).__name__}: {self.n} members>"

    def seed(self, member: int, seed: int | None) -> None:
        """Give a member a new generator with this seed; None: a random seed, but only if it has no generator yet."""
        if seed is not None or self.generators[member] is None:
            self.generators[member], self.generator_seeds[member] = np_random(seed)

    def begin(self, mask: Flags) -> Any:
        """Begin episodes for the members in a mask (n,); return the observations of all members."""
        self._restart(mask)
        observation = self.observe()
        self._judged()  # so that cells seen at the start earn no reward
        return observation

    def _restart(self, mask: Flags) -> None:
        members = np.flatnonzero(mask)
        draws = np.zeros((len(members), self.task.draws + len(self.ranges)))
        for row, member in enumerate(members.tolist()):
            self.seed(member, None)
            generator = self.generators[member]
            assert generator is not None
            self._seeds[member] = int(generator.integers(SEED_MAX))
            draws[row] = generator.random(draws.shape[1])
        self.batch.reset(mask, seeds=self._seeds, parameters=self._parameters(members, draws[:, self.task.draws :]))
        start = checked_start(self.task, self.task.start(members, draws[:, : self.task.draws]), members)
        self._place(mask, members, start.position_world_m, yaw_xyzw(start.yaw_rad))
        self.actions[members] = 0.0

    def _place(self, mask: Flags, members: NDArray[np.intp], position: Floats, orientation: Floats) -> None:
        positions, orientations = np.zeros((self.n, 3)), np.zeros((self.n, 4))
        positions[members], orientations[members] = position, orientation
        self.batch.place(positions, orientations, mask=mask, vehicle=self.task.vehicle)

    def _parameters(self, members: NDArray[np.intp], draws: Floats) -> list[Mapping[str, Any]] | None:
        if not self.ranges:
            return None
        low, high = np.array(list(self.ranges.values())).T
        values = (low + (high - low) * draws).tolist()
        parameters: list[Mapping[str, Any]] = [{}] * self.n
        for row, member in enumerate(members.tolist()):
            parameters[member] = dict(zip(self.ranges, values[row], strict=True))
        return parameters

    @property
    def motion(self) -> Motion:
        """The motion of all members at their last observation."""
        if self._motion is None:
            raise ValueError("motion: no episode has begun")
        return self._motion

    def observe(self) -> Any:
        """Return the observations of all members at the current time."""
        motion = self._motion = Motion.of(self.batch.observe(self.task.vehicle))
        observation = self.task.observe(motion, self.actions)
        require_observed(self.task, self._space, observation)
        if self.normalise:
            observation = self._scales.apply(observation)
        if self.eye is None:
            return observation
        state = observation if isinstance(observation, dict) else {"state": observation}
        return {**state, "camera": self.eye.pictures()}

    def resume(self) -> Any:
        """Return the observations after a saved state has been restored."""
        self._seeds = list(self.batch.seeds)
        return self.observe()

    def step(self, actions: Any, restarting: Flags | None = None) -> Outcome:
        """Apply actions (n, axes and joints) for one period.

        Members in `restarting` (n,) begin new episodes and get no reward.

        Raises ValueError for actions outside [-1, 1].
        """
        self.actions[...] = self._checked(actions)
        before = self.motion
        self._move_joints()
        diverged = self._advance(checked_efforts(self.task, self.task.efforts(self.actions, before)), before.time_s)
        if restarting is not None:
            self._restart(restarting)
        observation, verdict = self.observe(), self._judged()
        reward, terminated, figures = verdict.reward, verdict.terminated, dict(verdict.figures)
        truncated = self.motion.time_s > self.duration_s - 0.5 * self.period_s
        if diverged is not None:
            figures["diverged"] = diverged
            terminated = terminated | diverged
        if restarting is not None:
            reward, terminated = np.where(restarting, 0.0, reward), terminated & ~restarting
        return Outcome(observation, reward, terminated, truncated, figures)

    def _move_joints(self) -> None:
        if self._fastest:
            shares = dict(zip(self.task.action_names(), self.actions.T, strict=True))
            speeds = {
                joint: shares[name] * most for name, each in self._fastest.items() for joint, most in each.items()
            }
            self.batch.set_joints(speeds=speeds, vehicle=self.task.vehicle)

    def _judged(self) -> Verdict:
        return checked_verdict(self.task, self.task.judge(self.motion, self.actions))

    def _advance(self, efforts: Floats, before_s: Floats) -> Flags | None:
        """Step the batch; return a mask of the members whose motion diverged, or None if none did."""
        try:
            self.batch.step(self.steps, {self.task.vehicle: efforts})
        except ValueError:
            late = 1e-9 * self.batch.observe(self.task.vehicle).time_ns < before_s + 0.5 * self.period_s
            if not late.any():
                raise
            return np.asarray(late)
        return None

    def _checked(self, actions: Any) -> Floats:
        values = np.asarray(actions, np.float64)
        if values.shape != self.actions.shape:
            raise ValueError(f"actions.shape = {values.shape}: expected {self.actions.shape}")
        outside = ~(np.abs(values) <= 1.0)  # also true for NaN
        if outside.any():
            member, column = np.argwhere(outside)[0].tolist()
            name = f"actions[{member}].{self.task.action_names()[column]}"
            hint = "gymnasium.wrappers.ClipAction clips them"
            raise ValueError(f"{name} = {values[member, column]:g}: must be in [-1, 1]; {hint}")
        return values

    def require_camera(self, camera: str) -> None:
        """Raise ValueError unless the vehicle has this camera."""
        cameras = list(self.batch.simulator(0).vehicles[self.task.vehicle].cameras)
        if camera not in cameras:
            known = f"must be one of {', '.join(cameras)}{did_you_mean(str(camera), cameras)}"
            raise ValueError(f"view.camera = {camera!r}: {known}")

    def render(self, member: int, view: View) -> NDArray[np.uint8]:
        """Return a picture (height, width, 3) of the current state from a camera on the member's vehicle."""
        vehicle = self.batch.simulator(member).vehicles[self.task.vehicle]
        camera = vehicle.cameras[view.camera]
        camera.change(camera.mount.resized(view.width, view.height))
        return np.asarray(camera.capture().rgb)


def task_scenario(kind: type[Task], scenario: AnyScenario | None) -> Scenario:
    """Return the scenario that replaces the task's own, or the task's own if none is given."""
    chosen = kind.scenario if scenario is None else scenario
    return load(chosen)


def require_driven(task: Task) -> None:
    """Raise ValueError unless the vehicle has actuators for all axes set by the task's actions."""
    driven = task.batch.simulator(0).vehicles[task.vehicle].controllable
    idle = [axis for axis in task.axes if axis not in driven]
    if idle:
        rule = f"nothing drives its {' and '.join(idle)}, which actions of {type(task).__name__} set"
        raise ValueError(f"vehicle '{task.vehicle}': {rule}")


def fastest_joints(task: Task) -> dict[str, dict[str, float]]:
    """Return the fastest speeds [rad/s or m/s] of the joints of each of a task's `joints`, by name.

    Raises ValueError unless the vehicle's arm has motors for them.
    """
    if not task.joints:
        return {}
    entry = next(entry for entry in task.batch.scenario.vehicles if entry.name == task.vehicle)
    known = {link.name: link.fastest for link in link_specs(entry.model.arm or {}) if link.strongest > 0.0}
    for joint in (joint for joints in task.joints.values() for joint in joints):
        if joint not in known:
            rule = f"must be one of {', '.join(known)}" if known else "its vehicle has no arm with motors"
            raise ValueError(f"{type(task).__name__}.joints: {joint!r}: {rule}{did_you_mean(str(joint), known)}")
    return {name: {joint: known[joint] for joint in joints} for name, joints in task.joints.items()}
