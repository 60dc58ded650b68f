"""Environments of two vehicles follow PettingZoo's API rules."""

from __future__ import annotations

import numpy as np
import pytest
from pettingzoo.test import parallel_api_test, parallel_seed_test

from uwsim.learning.pair import Exchange


def test_the_environment_passes_pettingzoos_tests() -> None:
    parallel_api_test(Exchange(duration_s=2.0), num_cycles=100)
    parallel_seed_test(lambda: Exchange(duration_s=2.0))


def test_each_sees_the_other_where_it_is() -> None:
    env = Exchange()
    seen, _ = env.reset(seed=2)
    motion = {name: env._batch.observe(name).position_world_m[0].copy() for name in env.agents}
    apart = np.linalg.norm(motion["port"] - motion["starboard"])
    for name in env.agents:
        assert np.linalg.norm(seen[name][21:24]) == pytest.approx(apart, rel=1e-5)


def test_both_end_when_they_collide() -> None:
    env = Exchange()
    env.reset(seed=1)
    x, y, z = env._batch.observe("starboard").position_world_m[0]
    env._batch.place([x, y + 0.2, z], vehicle="port")
    _, rewards, ended, _, _ = env.step({name: np.zeros(6, np.float32) for name in env.agents})
    assert ended == {"port": True, "starboard": True}
    assert max(rewards.values()) < -18.0
    assert env.agents == []
    with pytest.raises(ValueError, match="has ended"):
        env.step({})


def test_wrong_actions_are_named() -> None:
    env = Exchange()
    env.reset(seed=1)
    with pytest.raises(ValueError, match="'starboard' is missing"):
        env.step({"port": np.zeros(6, np.float32)})
    with pytest.raises(ValueError, match=r"actions\['port'\] = .* must be \(6,\)"):
        env.step({"port": np.full(6, 2.0, np.float32), "starboard": np.zeros(6, np.float32)})
