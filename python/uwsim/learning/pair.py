"""Two vehicles that exchange places, as a PettingZoo environment: `pip install 'uwsim[multi]'`."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.spaces import Box, Space
from gymnasium.utils.seeding import np_random
from numpy.typing import NDArray

from uwsim.base.extras import need_extra

need_extra("pettingzoo", "multi", "uwsim.learning.pair")

from pettingzoo import ParallelEnv  # noqa: E402, after the check

from uwsim.batch import Batch  # noqa: E402
from uwsim.learning.motion import Motion, yaw_xyzw  # noqa: E402
from uwsim.learning.options import EpisodeOptions  # noqa: E402
from uwsim.learning.task import Field, Floats, box, cut, spread  # noqa: E402
from uwsim.learning.tasks import StationKeeping  # noqa: E402
from uwsim.learning.view import RENDER_MODES, View  # noqa: E402
from uwsim.scenario import load  # noqa: E402
from uwsim.scenario.read.assets import assets_folder  # noqa: E402

OTHER = (
    Field("other_body", 3, 20.0, "m", "the vector to the other vehicle, in body axes"),
    Field("other_velocity_body", 3, 10.0, "m/s", "the other's velocity relative to one's own, in one's own body axes"),
)
CURRENT_M_S = 0.2
STRUCK = -20.0


class Exchange(ParallelEnv):  # type: ignore[misc]  # PettingZoo has no type stubs
    """Two BlueROV2 Heavy vehicles start 3 m apart in a gusty current; each must move to the other's start and stay.

    Observation: as in uwsim/StationKeeping-v0 with respect to the target, then the other vehicle's relative position
    and velocity. Reward: as in uwsim/StationKeeping-v0 with respect to the target, and -20 for both vehicles on a
    collision. Termination, for both: a collision, or one vehicle is 8 m from its target. Episodes are truncated after
    30 s.
    """

    metadata = {"name": "uwsim_exchange_v0", "render_modes": RENDER_MODES, "render_fps": 20}  # noqa: RUF012
    duration_s = 30.0
    lost_m = 8.0

    def __init__(
        self, *, render_mode: str | None = None, view: View | None = None, duration_s: float | None = None
    ) -> None:
        self.render_mode = render_mode
        self.view = (view or View()).checked(render_mode)
        if duration_s is not None:
            self.duration_s = EpisodeOptions(duration_s=duration_s).duration_s or self.duration_s
        scenario = load(assets_folder() / "learning" / "two_vehicles.yaml")
        self._batch = Batch(scenario, n=1, threads=1)
        starts = {entry.name: np.array(entry.start.position_m) for entry in scenario.vehicles if entry.start}
        self.possible_agents = list(starts)
        self.agents: list[str] = []
        self._starts = starts
        self._tasks = {name: StationKeeping(self._batch, name) for name in starts}
        for name, task in self._tasks.items():
            task.place_m = starts[self._other(name)]
        self._steps = round(StationKeeping.period_s / scenario.step_s)
        self._fields = (*StationKeeping.fields(), *OTHER)
        self._space, self._action_space = box(self._fields), next(iter(self._tasks.values())).action_space
        self._actions = {name: np.zeros((1, 6)) for name in starts}
        self._generator: np.random.Generator | None = None

    def _other(self, name: str) -> str:
        return next(other for other in self.possible_agents if other != name)

    def observation_space(self, agent: str) -> Space[Any]:
        """Return the space of a vehicle's observations."""
        return self._space

    def action_space(self, agent: str) -> Box:
        """Return the space of a vehicle's actions: six efforts."""
        return self._action_space

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, NDArray[np.float32]], dict[str, dict[str, Any]]]:
        """Begin an episode; with a seed, the first episode from that seed's generator. options: ignored."""
        if seed is not None or self._generator is None:
            self._generator, _ = np_random(seed)
        draws = self._generator
        east, north = (float(value) for value in draws.uniform(-CURRENT_M_S, CURRENT_M_S, 2))
        names = ("water.current_world_m_s.x", "water.current_world_m_s.y")
        parameters = dict(zip(names, (east, north), strict=True))
        self._batch.reset(seeds=[int(draws.integers(2**63))], parameters=parameters)
        for name, start in self._starts.items():
            position = start + spread(draws.random(3), -0.4, 0.4)
            self._batch.place(position, yaw_xyzw(spread(draws.random(1), -0.7, 0.7))[0], vehicle=name)
            self._actions[name][:] = 0.0
        self.agents = list(self.possible_agents)
        motions = self._motions()
        return {name: self._observed(name, motions) for name in self.agents}, {name: {} for name in self.agents}

    def _motions(self) -> dict[str, Motion]:
        return {name: Motion.of(self._batch.observe(name)) for name in self.possible_agents}

    def _observed(self, name: str, motions: dict[str, Motion]) -> NDArray[np.float32]:
        own, other = motions[name], motions[self._other(name)]
        velocity_world: Floats = np.einsum("nij,nj->ni", other.world_from_body, other.velocity_body[:, :3])
        relative = own.in_body(velocity_world) - own.velocity_body[:, :3]
        state = self._tasks[name].observe(own, self._actions[name])
        whole = np.concatenate([state, own.towards(other.position_world_m), relative], axis=1)
        return np.asarray(cut(whole, self._fields)[0])

    def step(self, actions: dict[str, NDArray[np.float32]]) -> tuple[
        dict[str, NDArray[np.float32]], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]
    ]:  # fmt: skip
        """Apply both actions for one period. Raises ValueError for actions outside [-1, 1]."""
        if not self.agents:
            raise ValueError("step: the episode has ended, or none has begun: reset() first")
        for name in self.agents:
            self._actions[name][0] = _checked(name, actions)
        self._batch.step(self._steps, self._actions)
        motions = self._motions()
        verdicts = {name: self._tasks[name].judge(motions[name], self._actions[name]) for name in self.agents}
        struck = any(motion.collisions[0] > 0 for motion in motions.values())
        away_m = {name: float(verdict.figures["distance_m"][0]) for name, verdict in verdicts.items()}
        ended = struck or max(away_m.values()) > self.lost_m
        is_over = float(motions[self.agents[0]].time_s[0]) > self.duration_s - 0.5 * StationKeeping.period_s
        rewards = {name: float(verdict.reward[0]) + STRUCK * struck for name, verdict in verdicts.items()}
        results = (
            {name: self._observed(name, motions) for name in self.agents}, rewards, dict.fromkeys(self.agents, ended),
            dict.fromkeys(self.agents, is_over), {name: {"distance_m": away_m[name]} for name in self.agents},
        )  # fmt: skip
        if ended or is_over:
            self.agents = []
        return results

    def render(self) -> NDArray[np.uint8] | None:
        """Return a picture (height, width, 3) from the first vehicle's camera, or None without a render_mode."""
        if self.render_mode is None:
            return None
        camera = self._batch.simulator(0).rov.cameras[self.view.camera]
        camera.change(camera.mount.resized(self.view.width, self.view.height))
        return np.asarray(camera.capture().rgb)

    def close(self) -> None:
        """Do nothing, since no resources are open."""


def _checked(name: str, actions: dict[str, NDArray[np.float32]]) -> Floats:
    if name not in actions:
        raise ValueError(f"actions: '{name}' is missing")
    values = np.asarray(actions[name], np.float64)
    if values.shape != (6,) or not (np.abs(values) <= 1.0).all():
        raise ValueError(f"actions['{name}'] = {values}: must be (6,), each in [-1, 1]")
    return values
