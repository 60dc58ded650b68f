"""Stable-Baselines3 trains on a batch; it is rarely installed where these tests run, because it needs torch."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("stable_baselines3")

from stable_baselines3 import PPO

from uwsim.examples.e06_own_task import StandOff
from uwsim.learning.stable_baselines import BatchVecEnv
from uwsim.learning.vector_env import BatchEnv


def test_ppo_learns_on_a_batch() -> None:
    env = BatchVecEnv("uwsim/StationKeeping-v1", 4, duration_s=0.5, threads=1)
    PPO("MlpPolicy", env, n_steps=16, batch_size=32, n_epochs=1, device="cpu").learn(128)


def test_the_last_observation_of_an_episode_is_in_its_info() -> None:
    env = BatchVecEnv("uwsim/StationKeeping-v1", 2, duration_s=0.1, threads=1)
    env.seed(3)
    first = env.reset()
    env.step(np.zeros((2, 6), np.float32))
    begun, _, ended, infos = env.step(np.zeros((2, 6), np.float32))
    assert ended.all()
    assert all(info["TimeLimit.truncated"] and info["episode"]["l"] == 2 for info in infos)
    assert not np.array_equal(infos[0]["terminal_observation"], begun[0])
    assert begun.shape == first.shape


def test_a_tasks_class_is_taken_and_rendered() -> None:
    env = BatchVecEnv(StandOff, 2, duration_s=0.5, threads=1, render_mode="rgb_array")
    env.seed(1)
    named = BatchEnv(StandOff, 2, duration_s=0.5, threads=1)
    assert env.reset().tobytes() == named.reset(seed=1)[0].tobytes()
    assert [picture.shape for picture in env.get_images()] == [(270, 480, 3)] * 2
    assert env.render().shape[2] == 3
    with pytest.raises(ValueError, match="must be a class derived from"):
        BatchVecEnv(int, 2)
