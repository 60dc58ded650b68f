"""Gymnasium environment for one member of a task."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from uwsim.learning.episodes import Episodes
from uwsim.learning.options import EpisodeOptions
from uwsim.learning.saved import restore_episodes, save_episodes
from uwsim.learning.task import Task
from uwsim.learning.view import RENDER_MODES, View


class LoneEnv(gymnasium.Env[Any, Any]):
    """An environment with one member of a task; its episodes equal those of a VectorEnv member with the same seed.

    task: the task's class. render_mode: "rgb_array" or None. view: camera and size of rendered pictures. options: see
    EpisodeOptions. Raises ValueError for invalid options, before anything is built.
    """

    metadata = {"render_modes": RENDER_MODES, "render_fps": 20}  # noqa: RUF012, as Env declares it

    def __init__(
        self, task: type[Task], *, render_mode: str | None = None, view: View | None = None, **options: Any
    ) -> None:
        self.render_mode = render_mode
        self.view = (view or View()).checked(render_mode)
        self.episodes = Episodes(task, 1, EpisodeOptions(**{"threads": 1, **options}))
        if render_mode is not None:
            self.episodes.require_camera(self.view.camera)
        self.metadata = {**self.metadata, "render_fps": round(1.0 / task.period_s)}
        self.observation_space = self.episodes.observation_space
        self.action_space = self.episodes.action_space
        self._ended = True

    def __repr__(self) -> str:
        return f"<LoneEnv of {type(self.episodes.task).__name__}>"

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode; with a seed, the first episode from that seed's generator.

        Raises ValueError for any option, since there are none.
        """
        if options:
            raise ValueError(f"options = {options!r:.60}: would have no effect")
        self.episodes.seed(0, seed)
        self._adopt_generator()
        self._ended = False
        return first(self.episodes.begin(np.ones(1, np.bool_))), {}

    def step(self, action: NDArray[np.float32]) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Apply an action for one period.

        Raises ValueError if the action is outside [-1, 1] or the episode has ended.
        """
        if self._ended:
            raise ValueError("step: the episode has ended, or none has begun: reset() first")
        outcome = self.episodes.step(np.asarray(action)[None])
        terminated, truncated = bool(outcome.terminated[0]), bool(outcome.truncated[0])
        self._ended = terminated or truncated
        info = {name: values[0].item() for name, values in outcome.figures.items()}
        return first(outcome.observation), float(outcome.reward[0]), terminated, truncated, info

    def save_state(self) -> bytes:
        """Save everything that the episode and those after it depend on. Raises ValueError before the first reset.

        The same environment, or another one made in the same way, can continue from it with bit-identical results.
        """
        return save_episodes(self.episodes, np.array([self._ended]))

    def restore_state(self, state: bytes) -> Any:
        """Continue from a saved state; return its observation.

        Raises ValueError if it is damaged or of another environment.
        """
        observation, ended = restore_episodes(self.episodes, state)
        self._adopt_generator()
        self._ended = bool(ended[0])
        return first(observation)

    def _adopt_generator(self) -> None:
        self._np_random = self.episodes.generators[0]
        self._np_random_seed = self.episodes.generator_seeds[0]

    def render(self) -> NDArray[np.uint8] | None:
        """Return a picture (height, width, 3) from a camera on the vehicle, or None without a render_mode."""
        if self.render_mode is None:
            return None
        return self.episodes.render(0, self.view)


def first(observation: Any) -> Any:
    """Return the first member's part of an observation."""
    if isinstance(observation, dict):
        return {name: part[0] for name, part in observation.items()}
    return observation[0]
