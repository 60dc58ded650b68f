"""Vector environments for Stable-Baselines3, each backed by one batch. They need `pip install 'uwsim[rl]'` (torch)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from uwsim.base.extras import need_extra

need_extra("stable_baselines3", "uwsim.learning.stable_baselines")

import gymnasium  # noqa: E402, after the check
from gymnasium.vector import AutoresetMode  # noqa: E402
from stable_baselines3.common.vec_env import VecEnv  # noqa: E402

import uwsim.learning  # noqa: E402, F401, registers the environments
from uwsim.learning.task import Task  # noqa: E402
from uwsim.learning.vector_env import BatchEnv  # noqa: E402


class BatchVecEnv(VecEnv):  # type: ignore[misc]  # stable_baselines3 is not installed where types are checked
    """A vector environment for PPO and similar algorithms: `BatchVecEnv("uwsim/StationKeeping-v1", 64)`.

    task: the name of a registered environment, or a Task class. options: passed to gymnasium.make_vec. Actions are
    clipped to [-1, 1]. With render_mode="rgb_array", `render` returns the pictures of all members in a grid. Raises
    ValueError.
    """

    def __init__(self, task: str | type[Task], num_envs: int, **options: Any) -> None:
        options = {"autoreset_mode": AutoresetMode.SAME_STEP, **options}
        made = (
            gymnasium.make_vec(task, num_envs, **options)
            if isinstance(task, str)
            else BatchEnv(task, num_envs, **options)
        )
        if not isinstance(made.unwrapped, BatchEnv):
            raise ValueError(f"task = {task!r}: is no environment of uwsim")
        self._env = made.unwrapped
        self._actions = np.zeros(self._env.action_space.shape or ())
        self._seed: int | None = None
        self._earned, self._lengths = np.zeros(num_envs), np.zeros(num_envs, np.intp)
        super().__init__(num_envs, self._env.single_observation_space, self._env.single_action_space)

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Use seed + i for member i at the next reset."""
        self._seed = seed
        return [None if seed is None else seed + i for i in range(self.num_envs)]

    def reset(self) -> Any:
        """Begin an episode for every member."""
        observation, _ = self._env.reset(seed=self._seed)
        self._seed = None
        self._earned[:], self._lengths[:] = 0.0, 0
        return observation

    def step_async(self, actions: Any) -> None:
        """Store the actions for `step_wait`."""
        self._actions = np.clip(actions, -1.0, 1.0)

    def step_wait(self) -> tuple[Any, Any, Any, list[dict[str, Any]]]:
        """Run one period. If a member ends, its info has terminal_observation and, as with Monitor, episode."""
        observation, reward, terminated, truncated, info = self._env.step(self._actions)
        self._earned += reward
        self._lengths += 1
        ended = terminated | truncated
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for k in np.flatnonzero(ended).tolist():
            episode = {"r": float(self._earned[k]), "l": int(self._lengths[k]), "t": 0.0}
            cut_short = bool(truncated[k] and not terminated[k])
            infos[k] = {"terminal_observation": info["final_obs"][k], "TimeLimit.truncated": cut_short}
            infos[k]["episode"] = episode
        self._earned[ended], self._lengths[ended] = 0.0, 0
        return observation, reward.astype(np.float32), ended, infos

    def get_images(self) -> Sequence[Any]:
        """Return a picture (height, width, 3) of each member, or None for each without a render_mode."""
        return self._env.render() or [None] * self.num_envs

    def close(self) -> None:
        """Do nothing, since no resources are open."""

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Return an attribute of the environment for each index."""
        return [getattr(self._env, attr_name)] * len(list(self._get_indices(indices)))

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Raise ValueError, since members share one environment."""
        raise ValueError(f"{attr_name}: members share one environment, whose attributes are fixed")

    def env_method(self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any) -> list[Any]:
        """Call a method of the environment once; return its result for each index."""
        result = getattr(self._env, method_name)(*method_args, **method_kwargs)
        return [result] * len(list(self._get_indices(indices)))

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """Return False for each index."""
        return [False] * len(list(self._get_indices(indices)))
