"""Train uwsim/StationKeeping-v1 by PPO (Stable-Baselines3, `pip install 'uwsim[rl]'`) and compare it with the PID.

    python tools/learn/ppo_station_keeping.py --steps 1000000

Training episodes are derived from the seed; those for the comparison have seeds from 1,000,000 on.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import torch
import typer
from stable_baselines3 import PPO

from uwsim.learning.episodes import Episodes
from uwsim.learning.options import EpisodeOptions
from uwsim.learning.pid import Pid
from uwsim.learning.returns import fly
from uwsim.learning.stable_baselines import BatchVecEnv
from uwsim.learning.tasks import StationKeeping

HELD_OUT = 1_000_000


def main(
    steps: Annotated[int, typer.Option(min=1, help="Environment steps.")] = 1_000_000,
    members: Annotated[int, typer.Option(min=1)] = 64,
    compared: Annotated[int, typer.Option(min=1, help="Episodes for the comparison.")] = 64,
    seed: Annotated[int, typer.Option()] = 0,
    threads: Annotated[int, typer.Option(min=1, help="Threads of the simulation; torch uses one.")] = 1,
    out: Annotated[Path | None, typer.Option(help="The file for the model.")] = None,
) -> None:
    """Train and compare."""
    torch.set_num_threads(1)
    env = BatchVecEnv("uwsim/StationKeeping-v1", members, threads=threads)
    model = PPO(
        "MlpPolicy", env, n_steps=128, batch_size=2048, n_epochs=5, learning_rate=1e-3, gamma=0.98, gae_lambda=0.95,
        policy_kwargs={"log_std_init": -1.0, "net_arch": [32, 32]}, seed=seed, device="cpu",
    )  # fmt: skip
    begin = time.process_time()
    while model.num_timesteps < steps:
        model.learn(10 * 128 * members, reset_num_timesteps=False)
        earned = np.mean([episode["r"] for episode in model.ep_info_buffer])
        print(f"{model.num_timesteps:,} steps: return {earned:.1f}, {time.process_time() - begin:.0f} s", flush=True)
    arena = Episodes(StationKeeping, compared, EpisodeOptions(threads=threads))
    seeds = range(HELD_OUT, HELD_OUT + compared)

    def policy(observation: Any) -> Any:
        return np.clip(model.predict(observation, deterministic=True)[0], -1.0, 1.0)

    pid, learned = fly(arena, Pid(arena, StationKeeping.place_m), seeds), fly(arena, policy, seeds)
    for name, flown in (("PID", pid), ("PPO", learned)):
        print(f"{name}: return {flown.total.mean():.1f} +- {flown.total.std():.1f}, least {flown.total.min():.1f}")
    print(f"better than the PID in {(learned.total > pid.total).sum()} of {compared} episodes")
    if out is not None:
        model.save(out)


if __name__ == "__main__":
    typer.run(main)
