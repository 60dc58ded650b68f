"""Gymnasium vector environment for a task, with all members in one batch and stepped by one call."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from uwsim.batch.arguments import whole
from uwsim.learning.episodes import Episodes
from uwsim.learning.options import EpisodeOptions
from uwsim.learning.saved import restore_episodes, save_episodes
from uwsim.learning.task import Flags, Floats, Task
from uwsim.learning.view import RENDER_MODES, View

NO_MEMBERS = "reset_mask: bool ({n},) with at least one member is expected"


class BatchEnv(VectorEnv[Any, NDArray[Any], NDArray[Any]]):
    """A vector environment with num_envs members of a task. Returned arrays belong to the caller.

    autoreset_mode: as in Gymnasium. NEXT_STEP: the step after an episode's end begins the next episode and ignores the
    action. SAME_STEP: the step that ends an episode also begins the next, and info has `final_obs` and `final_info`.
    DISABLED: only reset(options={"reset_mask": mask}) begins episodes. render_mode, view, options: see LoneEnv.
    """

    metadata = {"render_modes": RENDER_MODES, "render_fps": 20}  # noqa: RUF012, as VectorEnv declares it

    def __init__(
        self,
        task: type[Task],
        num_envs: int = 1,
        *,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
        view: View | None = None,
        **options: Any,
    ) -> None:
        super().__init__()
        self.render_mode = render_mode
        self.view = (view or View()).checked(render_mode)
        self.num_envs = whole(num_envs, "num_envs", 1, 1_000_000)
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        self.episodes = Episodes(task, self.num_envs, EpisodeOptions(**options))
        if render_mode is not None:
            self.episodes.require_camera(self.view.camera)
        fps = round(1.0 / task.period_s)
        self.metadata = {**self.metadata, "render_fps": fps, "autoreset_mode": self.autoreset_mode}
        self.single_observation_space = self.episodes.observation_space
        self.single_action_space = self.episodes.action_space
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._ended = np.ones(self.num_envs, np.bool_)
        self._begun = False

    def __repr__(self) -> str:
        return f"<BatchEnv of {type(self.episodes.task).__name__}: {self.num_envs} members>"

    @property
    def np_random_seed(self) -> Any:  # read-only, with one entry per member, as in SyncVectorEnv
        """The seed of each member's generator, or -1 before the first reset."""
        return tuple(self.episodes.generator_seeds)

    @property  # type: ignore[misc]
    def np_random(self) -> Any:
        """Each member's random generator."""
        return tuple(self.episodes.generators)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin episodes for all members, or for options["reset_mask"] (n,) bool. Member i gets seed + i, or seed[i].

        Raises ValueError for a wrong number of seeds, any other option, or an invalid mask.
        """
        seeds = [None] * self.num_envs if seed is None else seed
        if isinstance(seeds, int | np.integer):
            seeds = [int(seeds) + i for i in range(self.num_envs)]
        if len(seeds) != self.num_envs:
            raise ValueError(f"seed: {len(seeds)} of them: expected one, or num_envs = {self.num_envs}")
        mask = self._mask(options or {})
        for member in np.flatnonzero(mask).tolist():
            self.episodes.seed(member, seeds[member])
        self._ended[mask] = False
        self._begun = True
        return self.episodes.begin(mask), {}

    def _mask(self, options: dict[str, Any]) -> Flags:
        others = set(options) - {"reset_mask"}
        if others:
            raise ValueError(f"options: {', '.join(sorted(others))}: would have no effect; there is reset_mask")
        if "reset_mask" not in options:
            return np.ones(self.num_envs, np.bool_)
        mask = np.asarray(options["reset_mask"])
        if mask.dtype != np.bool_ or mask.shape != (self.num_envs,) or not mask.any():
            raise ValueError(f"{mask.dtype} {mask.shape}: {NO_MEMBERS.format(n=self.num_envs)}")
        if not self._begun and not mask.all():
            raise ValueError("reset_mask: the first reset must be of all members")
        return mask

    def step(self, actions: NDArray[Any]) -> tuple[Any, Floats, Flags, Flags, dict[str, Any]]:
        """Apply actions (n, axes) for one period. Raises ValueError for actions outside [-1, 1]."""
        if not self._begun:
            raise ValueError("step: no episode has begun: reset() first")
        restarting = self._ended
        if self.autoreset_mode == AutoresetMode.DISABLED and restarting.any():
            members = ", ".join(map(str, np.flatnonzero(restarting)[:5].tolist()))
            raise ValueError(f"step: members {members} have ended: reset(options={{'reset_mask': mask}}) them first")
        outcome = self.episodes.step(actions, restarting if restarting.any() else None)  # only happens in NEXT_STEP
        observation, terminated, truncated = outcome.observation, outcome.terminated, outcome.truncated
        info = masked(outcome.figures, ~restarting)
        self._ended = terminated | truncated
        if self.autoreset_mode == AutoresetMode.SAME_STEP and self._ended.any():
            info = {**masked(outcome.figures, ~self._ended), "final_obs": parts(observation, self._ended)}
            info |= {"_final_obs": self._ended, "final_info": masked(outcome.figures, self._ended)}
            info["_final_info"] = self._ended.copy()
            begun, self._ended = self._ended, np.zeros(self.num_envs, np.bool_)
            observation = self.episodes.begin(begun)
        return observation, outcome.reward, terminated, truncated, info

    def save_state(self) -> bytes:
        """Save everything that the episodes of all members depend on. Raises ValueError before the first reset.

        The same environment, or another one made in the same way, can continue from it with bit-identical results.
        """
        return save_episodes(self.episodes, self._ended)

    def restore_state(self, state: bytes) -> Any:
        """Continue from a saved state; return the observations of all members.

        Raises ValueError if it is damaged or of another environment.
        """
        observation, self._ended = restore_episodes(self.episodes, state)
        self._begun = True
        return observation

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """Return a picture (height, width, 3) of each member, or None without a render_mode."""
        if self.render_mode is None:
            return None
        return tuple(self.episodes.render(k, self.view) for k in range(self.num_envs))


def masked(figures: dict[str, NDArray[Any]], mask: Flags) -> dict[str, Any]:
    """Return values in the format of Gymnasium's vector info, each with a mask (n,) of the members that have it."""
    if not mask.any():
        return {}
    info: dict[str, Any] = {}
    for name, values in figures.items():
        info[name] = np.where(mask, values, np.zeros_like(values))
        info[f"_{name}"] = mask.copy()
    return info


def parts(observation: Any, mask: Flags) -> NDArray[Any]:
    """Return an object array (n,) with the observations of the members in a mask, and None for the others."""
    each = np.full(len(mask), None, object)
    for member in np.flatnonzero(mask).tolist():
        if isinstance(observation, dict):
            each[member] = {name: part[member] for name, part in observation.items()}
        else:
            each[member] = observation[member]
    return each
