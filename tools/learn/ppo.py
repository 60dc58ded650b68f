"""Train policies by PPO (Stable-Baselines3, `pip install 'uwsim[rl]'`): station keeping, and a sonar task.

    python tools/learn/ppo.py --curve docs/guides/learning-ppo.png      # both, in turn
    python tools/learn/ppo.py StandOff --out stand_off.zip

The policy is evaluated between rollouts on held-out episodes, whose seeds begin at 1,000,000. The processor time is
that of training alone. Everything runs on one thread.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import torch
import typer
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback

from uwsim.examples.e06_own_task import StandOff
from uwsim.learning.episodes import Episodes
from uwsim.learning.options import EpisodeOptions
from uwsim.learning.pid import Pid
from uwsim.learning.returns import Flown, fly
from uwsim.learning.stable_baselines import BatchVecEnv
from uwsim.learning.task import Floats, Task
from uwsim.learning.tasks import StationKeeping

COMPARED = 64
HELD_OUT_SEEDS = range(1_000_000, 1_000_000 + COMPARED)
EVERY = 10  # rollouts between measurements
ROLLOUT = 4096  # environment steps between updates
SETTLED = 100  # the last steps of an episode, in all of which a task must succeed to count as solved


@dataclass(frozen=True)
class Recipe:
    """A task, its number of training steps, the discount, and the log of the initial policy's deviation."""

    task: type[Task]
    steps: int
    gamma: float
    log_std: float


@dataclass
class Course(BaseCallback):  # type: ignore[misc]  # stable_baselines3 is not installed where types are checked
    """The progress of a training: processor time [s], return in held-out episodes, and share of them solved."""

    recipe: Recipe
    processor_s: list[float] = field(default_factory=list)
    earned: list[float] = field(default_factory=list)
    solved: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Create the held-out episodes."""
        super().__init__()
        self.arena = Episodes(self.recipe.task, COMPARED, EpisodeOptions(threads=1))
        self._rollouts, self._begun_s = 0, 0.0

    def _on_training_start(self) -> None:
        self._begun_s = time.process_time()

    def _on_step(self) -> bool:
        return True

    def _on_rollout_start(self) -> None:
        if self._rollouts % EVERY == 0:
            self.measure()
        self._rollouts += 1

    def _on_training_end(self) -> None:
        self.measure()

    def measure(self) -> None:
        """Fly the held-out episodes, outside the measured time."""
        paused_s = time.process_time()
        flown = fly(self.arena, self.policy, HELD_OUT_SEEDS)
        self.processor_s.append(paused_s - self._begun_s)
        self.earned.append(float(flown.total.mean()))
        self.solved.append(solved(flown))
        print(
            f"{self.num_timesteps:,} steps, {self.processor_s[-1]:.1f} s: return {flown.total.mean():.1f} +- "
            f"{flown.total.std():.1f}, {100 * self.solved[-1]:.0f} % solved",
            flush=True,
        )
        self._begun_s += time.process_time() - paused_s

    def policy(self, observation: Any) -> Floats:
        """Return the actions of the current policy, without noise."""
        return np.clip(self.model.predict(observation, deterministic=True)[0], -1.0, 1.0)


def solved(flown: Flown) -> float:
    """Return the share of episodes with `success` in each of their last steps; NaN if `info` has no `success`."""
    if "success" not in flown.figures:
        return float("nan")
    return float((flown.figures["success"][-SETTLED:] == 1.0).all(axis=0).mean())


RECIPES = {
    "StationKeeping": Recipe(StationKeeping, 450_000, 0.98, -1.0),
    "StandOff": Recipe(StandOff, 450_000, 0.95, -1.5),
}


def main(
    names: Annotated[list[str] | None, typer.Argument(help="StationKeeping, StandOff; default: both.")] = None,
    members: Annotated[int, typer.Option(min=1)] = 64,
    seed: Annotated[int, typer.Option()] = 0,
    out: Annotated[Path | None, typer.Option(help="The file for the last model.")] = None,
    curve: Annotated[Path | None, typer.Option(help="The file for the picture.")] = None,
) -> None:
    """Train, compare and plot."""
    torch.set_num_threads(1)
    courses = {}
    for name in names or list(RECIPES):
        print(name)
        courses[name] = Course(RECIPES[name])
        model = train(courses[name], members, seed)
        if RECIPES[name].task is StationKeeping:
            compare(courses[name])
        if out is not None:
            model.save(out)
    if curve is not None:
        draw(courses, curve)


def train(course: Course, members: int, seed: int) -> PPO:
    """Train for the steps of the course's recipe; print and store the progress."""
    recipe = course.recipe
    model = PPO(
        "MlpPolicy", BatchVecEnv(recipe.task, members, threads=1), n_steps=ROLLOUT // members, batch_size=1024,
        n_epochs=5, learning_rate=1e-3, gamma=recipe.gamma, gae_lambda=0.95, seed=seed, device="cpu",
        policy_kwargs={"log_std_init": recipe.log_std, "net_arch": [32, 32]},
    )  # fmt: skip
    return model.learn(recipe.steps, callback=course)


def compare(course: Course) -> None:
    """Print the number of held-out episodes in which the policy's return exceeds that of the vehicle's own PID."""
    pid, learned = (
        fly(course.arena, policy, HELD_OUT_SEEDS).total
        for policy in (Pid(course.arena, StationKeeping.place_m), course.policy)
    )
    print(f"PID: return {pid.mean():.1f}; PPO is better in {(learned > pid).sum()} of {COMPARED} episodes")


def draw(courses: dict[str, Course], path: Path) -> None:
    """Plot the return of each training, and the share of solved episodes, over processor time."""
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(1, len(courses), figsize=(5 * len(courses), 3.6), layout="constrained", squeeze=False)
    for panel, (name, course) in zip(panels[0], courses.items(), strict=True):
        panel.plot(course.processor_s, course.earned, "o-", ms=3, label="PPO, held-out seeds")
        if course.recipe.task is StationKeeping:
            pid = fly(course.arena, Pid(course.arena, StationKeeping.place_m), HELD_OUT_SEEDS)
            panel.axhline(pid.total.mean(), ls="--", color="k", lw=1, label="PID of the vehicle's file")
        panel.set(xlabel="processor time [s]", ylabel="return of an episode", title=name)
        if np.isfinite(course.solved).all():
            share = panel.twinx()
            share.plot(course.processor_s, 100 * np.array(course.solved), "C1-", lw=1.5, label="solved")
            share.set(ylabel="solved episodes [%]", ylim=(-3, 103))
            panel.plot([], [], "C1-", label="solved")
        panel.grid(alpha=0.3)
        panel.legend(loc="lower right", fontsize=8)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
    plt.close(figure)


if __name__ == "__main__":
    typer.run(main)
