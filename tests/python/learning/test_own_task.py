"""A task of one's own: what it returns is checked, it is registered in one call, and its state is saved."""

from __future__ import annotations

import io
import re
import warnings
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import uwsim.learning
from uwsim.examples import e06_own_task
from uwsim.examples.e06_own_task import StandOff
from uwsim.learning.lone_env import LoneEnv
from uwsim.learning.task import Field, Start, Task, Verdict
from uwsim.learning.tasks import Coverage, Docking, PipelineFollowing
from uwsim.learning.vector_env import BatchEnv
from uwsim.learning.view import View

PAGE = Path(__file__).parents[3] / "docs" / "guides" / "own-task.md"
N = 4


class Plain(Task):
    """Does nothing in particular, without a sonar."""

    scenario = e06_own_task.TANK
    duration_s = 1.0
    draws = 1
    goal_fields = (Field("north", 2, 50.0, "m", "north of the origin, and of the first member"),)

    def start(self, members: Any, draws: Any) -> Start:
        zero = np.zeros(len(members))
        return Start(np.column_stack([zero, 2.0 * draws[:, 0], zero - 4.0]), zero)

    def goal(self, now: Any) -> Any:
        return np.tile(now.position_world_m[:, 1:2], 2)

    def judge(self, now: Any, actions: Any) -> Verdict:
        return Verdict(-now.time_s, now.time_s > 9.0, {"x_m": now.position_world_m[:, 0]})


def with_nan(values: Any, at: Any) -> Any:
    changed = np.array(values, float)
    changed[at] = np.nan
    return changed


def verdict(**changes: Any) -> dict[str, Any]:
    """Return the attributes of a Plain whose verdict has these values, as functions of the time (n,)."""

    def judge(self: Task, now: Any, actions: Any) -> Any:
        given = {"reward": now.time_s, "terminated": now.time_s > 9.0, "figures": {}}
        return Verdict(**{**given, **{key: value(now.time_s) for key, value in changes.items()}})

    return {"judge": judge}


BAD = [
    (verdict(reward=lambda t: t[:3]), r"Broken.judge: reward.shape = \(3,\): must be \(4,\)"),
    (verdict(reward=lambda t: t[:, None]), r"Broken.judge: reward.shape = \(4, 1\): must be \(4,\)"),
    (verdict(reward=lambda t: with_nan(t, 2)), "Broken.judge: member 2, reward = nan: must be finite"),
    (verdict(reward=lambda t: t.astype(str)), "Broken.judge: reward.dtype = <U32: must be float64"),
    (verdict(terminated=lambda t: 0 * t), "Broken.judge: terminated.dtype = float64: must be bool"),
    (verdict(terminated=lambda t: t[1:] > 1.0), r"Broken.judge: terminated.shape = \(3,\)"),
    (verdict(figures=lambda t: {"x_m": t[:1]}), r"Broken.judge: figures\['x_m'\].shape = \(1,\): must be \(4,\)"),
    (verdict(figures=lambda t: [t]), "Broken.judge: figures is list: must be a mapping"),
    ({"judge": lambda self, now, actions: (now.time_s, now.time_s > 1.0)}, "Broken.judge: returned tuple"),
    ({"goal": lambda self, now: now.position_world_m}, r"Broken.goal: goal.shape = \(4, 3\): must be \(4, 2\)"),
    ({"goal": lambda self, now: with_nan(Plain.goal(self, now), (3, 1))}, r"Broken.goal: member 3, goal\[1\] = nan"),
    ({"goal": lambda self, now: Plain.goal(self, now) * 1j}, "Broken.goal: goal.dtype = complex128"),
    ({"start": lambda self, members, draws: Start(np.zeros((1, 3)), np.zeros(4))}, r"position_world_m.shape = \(1, "),
    ({"start": lambda self, members, draws: Start(np.zeros((4, 3)), [0, 0, np.inf, 0])}, "member 2, yaw_rad = inf"),
    ({"start": lambda self, members, draws: np.zeros((4, 3))}, "Broken.start: returned ndarray: must return Start"),
    ({"efforts": lambda self, actions, now: actions + 2.0}, "Broken.efforts: member 0, surge = 2: must be in"),
    ({"efforts": lambda self, actions, now: actions[:2]}, r"Broken.efforts: efforts.shape = \(2, 6\)"),
    ({"observe": lambda self, now, actions: np.zeros((4, 17))}, "observation.dtype = float64: must be float32"),
    ({"observe": lambda self, now, actions: [0.0]}, "Broken.observe: observation is list"),
    (
        {"observe": lambda self, now, actions: np.full((4, 17), 51.0, np.float32)},
        r"Broken.observe: member 0, observation\[0\] = 51: must be in \[-50, 50\]",
    ),
    ({"axes": ("surge", "sawy")}, "Broken.axes: 'sawy': must be one of .*; did you mean 'sway'"),
    ({"axes": ("surge", "surge")}, "Broken.axes = .*: must be different names"),
    ({"joints": {"grip": ("left",)}}, "Broken.joints: 'left': its vehicle has no arm with motors"),
    ({"joints": {"grip": "left"}}, "Broken.joints = .*: must be lists of joints by name"),
    ({"joints": {"surge": ("left",)}}, "Broken.joints: 'surge': is the name of an axis"),
    ({"draws": -1}, "Broken.draws = -1: must be a whole number"),
    ({"period_s": 0.0}, "Broken.period_s = 0.0 s: must be a positive number"),
    ({"period_s": 0.0033}, "the period of an action, 0.0033 s, must be a whole number of steps"),
    ({"goal_fields": Plain.goal_fields[0]}, "Broken.goal_fields = .*: must be a tuple of Field"),
    ({"goal_fields": (*Plain.goal_fields, *Plain.goal_fields)}, "two fields have the name 'north'"),
    ({"__init__": lambda self, batch: None}, r"Broken.__init__: must call super\(\).__init__"),
    ({"scenario": {**e06_own_task.TANK, "terain": {}}}, "terain"),
]


@pytest.mark.parametrize(("changes", "message"), BAD)
def test_what_a_task_returns_is_refused_by_name_of_method_and_member(changes: dict[str, Any], message: str) -> None:
    broken = type("Broken", (Plain,), changes)
    with pytest.raises(ValueError, match=message):
        env = BatchEnv(broken, N, threads=1)
        env.reset(seed=1)
        env.step(np.zeros((N, len(broken.axes))))


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        (int, "must be a class derived from"),
        ("Plain", "must be a class derived from"),
        (type("Half", (Task,), {"scenario": "pool"}), "Half: does not define goal, judge, start"),
        (type("NoScenario", (Coverage,), {"draws": None}), "NoScenario.draws = None"),
    ],
)
def test_what_is_no_whole_task_is_refused_where_it_is_registered(kind: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        uwsim.learning.register("test/Half-v0", kind)
    assert "test/Half-v0" not in gymnasium.registry


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"width": 0}, "width = 0"),
        ({"limit": np.inf}, "must be finite"),
        ({"low": 2.0}, "range 2 to 1 m: must be finite and ascending"),
        ({"usual": (1.0, 1.0)}, "usual has 2 values: must have 3, or none"),
        ({"usual": (1.0, 0.0, 1.0)}, "must be positive"),
    ],
)
def test_a_wrong_field_is_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=f"field 'way': {message}|field 'way': .*{message}"):
        Field(**{"name": "way", "width": 3, "limit": 1.0, "unit": "m", "about": "", **given})


def test_registered_in_one_call_it_is_made_by_name() -> None:
    uwsim.learning.register("test/StandOff-v0", StandOff, duration_s=2.0)
    try:
        env = gymnasium.make("test/StandOff-v0", render_mode="rgb_array")
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            check_env(env.unwrapped)
        vector, own = gymnasium.make_vec("test/StandOff-v0", num_envs=2), BatchEnv(StandOff, 2, duration_s=2.0)
        assert vector.reset(seed=5)[0].tobytes() == own.reset(seed=5)[0].tobytes()
        assert env.reset(seed=6)[0].tobytes() == own.reset(seed=5)[0][1].tobytes()
        assert env.render().std() > 1.0
    finally:
        del gymnasium.registry["test/StandOff-v0"]


def test_observed_values_are_divided_by_their_usual_sizes() -> None:
    sizes = np.array([size for field in StandOff.fields() for size in field.sizes], np.float32)
    usual, plain = BatchEnv(StandOff, 2), BatchEnv(StandOff, 2, normalise=False)
    seen, measured = usual.reset(seed=3)[0], plain.reset(seed=3)[0]
    assert (seen == measured / sizes).all() and usual.observation_space.contains(seen)
    assert (usual.single_observation_space.high == plain.single_observation_space.high / sizes).all()
    assert 1.0 < measured[:, :16].min() < measured[:, :16].max() <= 20.0  # [m]
    older = gymnasium.make("uwsim/StationKeeping-v0", disable_env_checker=True)
    assert older.observation_space.high[0] == 10.0  # [m], as it always was


def test_a_dicts_state_is_divided_and_its_map_is_not() -> None:
    usual, plain = BatchEnv(Coverage, 1), BatchEnv(Coverage, 1, normalise=False)
    seen, measured = usual.reset(seed=3)[0], plain.reset(seed=3)[0]
    assert (seen["state"] * 2.0)[0, 0] == measured["state"][0, 0] != 0.0
    assert (seen["map"] == measured["map"]).all() and usual.observation_space.contains(seen)


FAULTS = {"faults": [{"kind": "thruster", "axis": "surge", "health": 0.0, "rate_per_h": 36000.0, "for_s": 0.2}]}


def flown(env: BatchEnv, actions: Any) -> list[bytes]:
    """Return the bytes of everything that the environment returns for these actions."""
    found = []
    for each in actions:
        observation, *rest, info = env.step(each)
        parts = [observation] if isinstance(observation, np.ndarray) else list(observation.values())
        found += [np.asarray(part).tobytes() for part in (*parts, *rest, *info.values())]
    return found


@pytest.mark.parametrize(
    ("kind", "options"), [(StandOff, {}), (Docking, {}), (Coverage, {}), (PipelineFollowing, FAULTS)]
)
def test_a_restored_environment_continues_with_the_same_bytes(kind: type[Task], options: dict[str, Any]) -> None:
    """Also past the ends of episodes, in another environment, and on another number of threads."""
    first, other = (BatchEnv(kind, 3, duration_s=1.5, threads=threads, **options) for threads in (1, 2))
    first.reset(seed=1)
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (30, *first.action_space.shape))
    flown(first, actions[:4])
    state = first.save_state()
    expected = flown(first, actions)
    other.restore_state(state)
    assert flown(other, actions) == expected
    first.restore_state(state)
    assert flown(first, actions) == expected
    assert first.save_state() == other.save_state() != state


def test_a_lone_environment_is_saved_and_restored() -> None:
    env, other = LoneEnv(StandOff, duration_s=0.5), LoneEnv(StandOff, duration_s=0.5)
    with pytest.raises(ValueError, match="no episode has begun"):
        env.save_state()
    env.reset(seed=4)
    state = env.save_state()
    seen = other.restore_state(state)
    assert seen.tobytes() == env.restore_state(state).tobytes()
    assert other.np_random_seed == 4
    for _ in range(5):
        assert env.step(np.zeros(4))[0].tobytes() == other.step(np.zeros(4))[0].tobytes()
    with pytest.raises(ValueError, match="the episode has ended"):
        other.step(np.zeros(4))
    assert env.reset()[0].tobytes() == other.reset()[0].tobytes()


def changed(state: bytes, **parts: Any) -> bytes:
    """Return a saved state with some of its arrays replaced, or left out if None."""
    with np.load(io.BytesIO(state)) as file:
        arrays = {name: file[name] for name in file.files} | {name.replace("_", " "): v for name, v in parts.items()}
    out = io.BytesIO()
    np.savez(out, **{name: value for name, value in arrays.items() if value is not None})
    return out.getvalue()


def test_a_damaged_or_foreign_state_is_refused_and_changes_nothing() -> None:
    env = BatchEnv(StandOff, 2, threads=1)
    env.reset(seed=1)
    state = env.save_state()
    other = BatchEnv(StandOff, 3, threads=1)
    other.reset(seed=1)
    docking = BatchEnv(Docking, 2, threads=1)
    docking.reset(seed=1)
    cut = np.frombuffer(b"\0" * 50, np.uint8)
    for bad, message in [
        (b"", "is damaged"),
        (state[:-30], "is damaged"),
        ("text", "must be bytes"),
        (other.save_state(), "n = 3: this environment has 2"),
        (docking.save_state(), "task = 'Docking': this environment has 'StandOff'"),
        (changed(state, header=None), "JSON"),
        (changed(state, actions=np.zeros((1, 4))), r"actions: float64 \(1, 4\): must be float64 \(2, 4\)"),
        (changed(state, ended=None), "ended: is missing"),
        (changed(state, member_1=cut), "state"),
    ]:
        with pytest.raises(ValueError, match=message):
            env.restore_state(bad)  # type: ignore[arg-type]
        assert env.save_state() == state
    with pytest.raises(ValueError, match=r"Kept.kept is list: cannot be saved: use an array"):
        kept = BatchEnv(type("Kept", (Plain,), {"__init__": keeping_a_list}), 1)
        kept.reset(seed=1)
        kept.save_state()


def keeping_a_list(self: Any, batch: Any) -> None:
    Task.__init__(self, batch)
    self.kept = []


def test_an_unknown_camera_is_refused_when_the_environment_is_made() -> None:
    for make in (LoneEnv, BatchEnv):
        with pytest.raises(ValueError, match=r"view\.camera = 'frnt': must be one of .*; did you mean 'front'"):
            make(StandOff, render_mode="rgb_array", view=View("frnt"))


def test_objects_describe_themselves_in_a_line() -> None:
    env = BatchEnv(StandOff, 2, threads=1)
    env.reset(seed=1)
    things = [env, env.episodes, env.episodes.task, env.episodes.motion]
    assert all("\n" not in repr(one) and len(repr(one)) < 250 for one in things)
    assert all(repr(one) == f"<{type(one).__name__} of StandOff: 2 members>" for one in things[:2])


def test_the_page_shows_the_example() -> None:
    block = re.findall(r"```python\n(.*?)```", PAGE.read_text(), flags=re.DOTALL)[0]
    source = Path(e06_own_task.__file__).read_text()
    assert block.strip() in source
