"""Environments follow Gymnasium's rules; a vector environment's member equals the single environment of its seed."""

from __future__ import annotations

import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

from uwsim.learning import ENVIRONMENTS
from uwsim.learning.tasks import TASKS
from uwsim.scenario.read.assets import assets_folder

STATION = "uwsim/StationKeeping-v1"


def same(one: Any, other: Any) -> bool:
    """Return True if two observations have the same bytes."""
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    return bool(one.dtype == other.dtype and one.tobytes() == other.tobytes())


def member(observation: Any, k: int) -> Any:
    return {name: part[k] for name, part in observation.items()} if isinstance(observation, dict) else observation[k]


@pytest.mark.parametrize("name", ["StationKeeping", "Coverage", "Valve"])  # with a map, with an arm
def test_the_environment_passes_gymnasiums_check_without_warnings(name: str) -> None:
    env = gymnasium.make(f"uwsim/{name}-v1", render_mode="rgb_array")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped)


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_a_member_has_the_episodes_of_the_lone_environment_of_its_seed(name: str) -> None:
    vector = gymnasium.make_vec(name, num_envs=3, duration_s=1.0, threads=2)
    lone = gymnasium.make(name, duration_s=1.0)
    seen, (own, _) = vector.reset(seed=[8, 21, 5])[0], lone.reset(seed=21)
    draws, ends = np.random.default_rng(0), 0
    assert same(member(seen, 1), own)
    while ends < 2:
        actions = draws.uniform(-1.0, 1.0, vector.action_space.shape).astype(np.float32)
        seen, reward, terminated, truncated, info = vector.step(actions)
        own, paid, has_failed, is_over, told = lone.step(actions[1])
        assert same(member(seen, 1), own)
        assert (reward[1], terminated[1], truncated[1]) == (paid, has_failed, is_over)
        assert {key: info[key][1] for key in told} == told
        if has_failed or is_over:
            ends += 1
            own, _ = lone.reset()
            seen, reward, terminated, truncated, info = vector.step(actions)  # starts the next episode
            assert same(member(seen, 1), own)
            assert (reward[1], terminated[1], truncated[1]) == (0.0, False, False)


def ended_at(mode: AutoresetMode) -> tuple[Any, Any, Any]:
    """Step two members to the end of their short episodes; return the environment and the last two results."""
    vector = gymnasium.make_vec(STATION, num_envs=2, autoreset_mode=mode, duration_s=0.2)
    vector.reset(seed=1)
    results = [vector.step(np.zeros((2, 6), np.float32)) for _ in range(4)]
    return vector, results[-2], results[-1]


def test_same_step_shows_the_last_observation_in_info() -> None:
    vector, before, last = ended_at(AutoresetMode.SAME_STEP)
    assert last[3].all() and not before[3].any()
    following = ended_at(AutoresetMode.NEXT_STEP)
    assert same(np.stack(last[4]["final_obs"]), following[2][0])
    assert last[4]["final_info"]["distance_m"].tolist() == following[2][4]["distance_m"].tolist()
    begun = following[0].step(np.zeros((2, 6), np.float32))[0]
    assert same(last[0], begun)
    assert not vector.step(np.zeros((2, 6), np.float32))[3].any()


def test_without_autoreset_the_user_resets_by_a_mask() -> None:
    vector, _, last = ended_at(AutoresetMode.DISABLED)
    with pytest.raises(ValueError, match="members 0, 1 have ended"):
        vector.step(np.zeros((2, 6), np.float32))
    seen, _ = vector.reset(options={"reset_mask": np.array([True, False])})
    assert not same(seen[0], last[0][0]) and same(seen[1], last[0][1])


def test_parameters_are_drawn_for_each_episode() -> None:
    ranges = {"rov.mass_kg": (13.0, 14.5), "rov.thrusters.front_left.health": (0.3, 1.0)}
    vector = gymnasium.make_vec(STATION, num_envs=3, randomize=ranges)
    vector.reset(seed=3)
    batch = vector.unwrapped.episodes.batch
    assert batch.n == 3 and vector.observation_space.shape == (3, 21)
    masses = [one["rov.mass_kg"] for one in batch.parameters]
    assert len(set(masses)) == 3 and all(13.0 <= mass <= 14.5 for mass in masses)
    currents = [one["water.current_world_m_s.x"] for one in batch.parameters]
    assert len(set(currents)) == 3
    assert batch.simulator(1).parameters["rov.mass_kg"] == masses[1]
    vector.reset(seed=3)
    assert [one["rov.mass_kg"] for one in batch.parameters] == masses


def test_pictures_are_a_part_of_the_observation_and_each_member_is_rendered() -> None:
    pipeline = "uwsim/PipelineFollowing-v1"
    options = {"camera": "front", "camera_size": (20, 30)}
    vector = gymnasium.make_vec(pipeline, num_envs=2, threads=2, render_mode="rgb_array", **options)
    lone = gymnasium.make(pipeline, **options)
    seen, _ = vector.reset(seed=4)
    assert vector.observation_space["camera"].shape == (2, 20, 30, 3)
    assert vector.observation_space.contains(seen) and seen["camera"].std() > 0
    assert same(member(seen, 1), lone.reset(seed=5)[0])
    pictures = vector.render()
    assert [picture.shape for picture in pictures] == [(270, 480, 3)] * 2 and pictures[0].std() > 1.0


FAULTS = [
    {"kind": "thruster", "axis": "surge", "health": 0.0, "rate_per_h": 36000.0, "for_s": 0.2},
    {"kind": "sensor", "sensor": "altitude", "mode": "bias", "bias": 3.0, "at_s": 0.3},
]


def test_episodes_with_faults_and_a_sonar_in_physics_mode_follow_from_the_seed() -> None:
    pipeline, options = "uwsim/PipelineFollowing-v1", {"faults": FAULTS, "sonar_mode": "physics", "normalise": False}
    vector, lone = gymnasium.make_vec(pipeline, num_envs=2, **options), gymnasium.make(pipeline, **options)
    plain = gymnasium.make_vec(pipeline, num_envs=2, sonar_mode="geometry", normalise=False)
    (seen, _), (well, _), (own, _) = vector.reset(seed=6), plain.reset(seed=6), lone.reset(seed=7)
    assert not np.array_equal(seen[:, :64], well[:, :64])  # noise changes the echoes
    actions = np.full((2, 4), 0.5, np.float32)
    for _ in range(10):
        seen, well, own = vector.step(actions)[0], plain.step(actions)[0], lone.step(actions[1])[0]
        assert same(seen[1], own)
    np.testing.assert_allclose(seen[:, 64] - well[:, 64], 3.0, atol=0.5)
    begun = [vector.unwrapped.episodes.batch.aboard(k).events[0].time_s for k in range(2)]
    assert begun[0] != begun[1]


def test_a_camera_that_fails_shows_black_and_a_sonar_nothing() -> None:
    blind = [{"kind": "camera", "camera": "front", "at_s": 0.1}, {"kind": "sonar", "at_s": 0.1}]
    vector = gymnasium.make_vec(
        "uwsim/PipelineFollowing-v1", num_envs=2, camera="front", camera_size=(12, 12), faults=blind, normalise=False
    )
    seen, _ = vector.reset(seed=4)
    assert seen["camera"].any() and (seen["state"][:, :64] < 20.0).any()
    for _ in range(2):
        seen = vector.step(np.zeros((2, 4), np.float32))[0]
    assert not seen["camera"].any() and (seen["state"][:, :64] == 20.0).all()
    with pytest.raises(ValueError, match="camera 'front': is not observed"):
        gymnasium.make("uwsim/PipelineFollowing-v1", faults=blind)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        ({"randomize": {"rov.mas_kg": (1, 2)}}, r"randomize\['rov.mas_kg'\]: is not a parameter; did you mean"),
        ({"randomize": {"rov.mass_kg": (2, 1)}}, r"low must not exceed high"),
        ({"randomize": {"rov.mass_kg": 3}}, r"must be \(low, high\)"),
        ({"randomize": {"rov.mass_kg": (-1, 3)}}, r"rov.mass_kg = -1"),
        ({"duration_s": 0.0}, "duration_s = 0.0 s: must be positive"),
        ({"camera_size": (10, 10)}, "camera_size: has no effect"),
        ({"camera": "frnt"}, "camera = 'frnt': must be one of"),
        ({"render_mode": "human"}, "render_mode = 'human'"),
        ({"num_envs": 0}, "num_envs = 0"),
        ({"sonar_mode": "physics"}, "sonar_mode = 'physics': has no effect: StationKeeping uses no sonar"),
        ({"faults": [{"kind": "sensor", "sensor": "imu", "at_s": 1}]}, "'imu': StationKeeping reads none"),
        ({"faults": [{"kind": "sonar", "at_s": 1}]}, "StationKeeping uses no sonar"),
        ({"faults": [{"kind": "camera", "camera": "front", "at_s": 1}]}, "camera = 'front': must be one of none"),
        ({"faults": [{"kind": "link", "at_s": 1}]}, "the scenario has no link"),
        ({"faults": [{"kind": "thruster", "thruster": "frnt", "at_s": 1}]}, "thruster = 'frnt': must be one of"),
    ],
)
def test_wrong_options_are_named(make: dict[str, Any], message: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # Gymnasium warns about unknown render modes
        with pytest.raises(ValueError, match=message):
            gymnasium.make_vec(STATION, **{"num_envs": 1, **make})


def test_a_vehicle_that_cannot_do_what_actions_say_is_refused(tmp_path: Path) -> None:
    text = (assets_folder() / "learning" / "open_water.yaml").read_text()
    (tmp_path / "remus.yaml").write_text(text.replace("bluerov2_heavy", "remus100"))
    with pytest.raises(ValueError, match="vehicle 'rov': nothing drives its sway"):
        gymnasium.make_vec(STATION, num_envs=1, scenario=tmp_path / "remus.yaml")
    with pytest.raises(ValueError, match="vehicle 'rov': its sonar has 513 beams: the task needs 64"):
        gymnasium.make("uwsim/PipelineFollowing-v1", scenario="cove").reset()


@pytest.mark.parametrize(
    ("actions", "message"),
    [
        (np.full((2, 6), 1.5), r"actions\[0\].surge = 1.5: must be in \[-1, 1\]"),
        (np.full((2, 6), np.nan), r"actions\[0\].surge = nan"),
        (np.zeros((2, 5)), r"actions.shape = \(2, 5\): expected \(2, 6\)"),
    ],
)
def test_wrong_actions_are_named(actions: Any, message: str) -> None:
    vector = gymnasium.make_vec(STATION, num_envs=2)
    with pytest.raises(ValueError, match="no episode has begun"):
        vector.step(actions)
    vector.reset(seed=1)
    with pytest.raises(ValueError, match=message):
        vector.step(actions)


def test_one_whose_motion_diverges_ends_and_the_others_go_on() -> None:
    drag = {f"rov.drag.quadratic.{axis}": (5e3, 5e3) for axis in ("surge", "sway", "heave")}
    vector = gymnasium.make_vec(STATION, num_envs=2, randomize=drag)
    vector.reset(seed=1)
    batch = vector.unwrapped.episodes.batch
    fast = np.array([[90.0, 90.0, 0, 0, 0, 0], [0.0] * 6])
    batch.place([0.0, 0.0, -7.0], velocity_body=fast, mask=np.array([True, False]))
    vector.unwrapped.episodes.observe()
    _, _, terminated, _, info = vector.step(np.zeros((2, 6), np.float32))
    assert terminated.tolist() == [True, False]
    assert info["diverged"].tolist() == [True, False]
    _, _, terminated, _, _ = vector.step(np.zeros((2, 6), np.float32))
    assert not terminated.any()


def test_gymnasium_imports_what_registers_them_by_their_long_name_which_loads_no_simulator() -> None:
    """Gymnasium 1 no longer uses entry points; "module:id" creates an environment without a prior import."""
    make = f"import gymnasium; print(gymnasium.make('uwsim.learning:{STATION}').spec.id)"
    loaded = "import uwsim.learning, sys; print('uwsim._core' in sys.modules)"
    for program, printed in ((make, STATION), (loaded, "False")):
        run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
        assert run.stdout.strip() == printed
    assert set(ENVIRONMENTS) == {f"uwsim/{name}-v1" for name in TASKS} <= set(gymnasium.registry)
