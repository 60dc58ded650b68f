"""Saved states of environments: all members, their random generators and the task's own arrays.

A state may come from an untrusted source: it contains no pickled objects, and is checked before any of it is used.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from gymnasium.utils.seeding import np_random
from numpy.typing import NDArray
from pydantic import Field

from uwsim.base.npz import npz_bytes, read_npz
from uwsim.base.saved_state import State, checked
from uwsim.batch import Batch
from uwsim.learning.episodes import Episodes
from uwsim.learning.task import Flags, Task

HEADER, ACTIONS, ENDED, MEMBER, ARRAY = "header", "actions", "ended", "member ", "task "
FIXED = ("batch", "vehicle", "columns")
"""Attributes of every task that do not change."""
PLAIN = (bool, int, float, str, type(None))
CONTAINERS = (list, dict, set, bytearray, np.random.Generator)
"""Attributes of these types could change unnoticed."""
Word = Annotated[int, Field(ge=0, lt=2**128)]


class GeneratorState(State):
    """The state of a member's random generator, PCG64, and the seed that it began with."""

    seed: int
    state: Word
    inc: Word
    has_uint32: Literal[0, 1]
    uinteger: Annotated[int, Field(ge=0, lt=2**32)]


class Definition(State):
    """The definition of a batch member: its seed, parameters and initial faults."""

    seed: int
    parameters: dict[str, Any]
    faults: list[dict[str, Any]]


class Header(State):
    """Everything in a saved state except its arrays."""

    task: str
    n: int
    normalise: bool
    generators: list[GeneratorState]
    members: list[Definition]
    plain: dict[str, bool | int | float | str | None]


def save_episodes(episodes: Episodes, ended: Flags) -> bytes:
    """Return everything that the episodes' future depends on. ended: (n,). Raises ValueError before the first episode.

    Also raises ValueError if the task has attributes that could change and are not arrays, numbers or strings.
    """
    arrays, plain = task_state(episodes.task)
    generators = [_saved_generator(episodes, k) for k in range(episodes.n)]
    header = Header(
        task=type(episodes.task).__name__,
        n=episodes.n,
        normalise=episodes.normalise,
        generators=generators,
        members=_definitions(episodes.batch),
        plain=plain,
    )
    parts = {
        HEADER: np.frombuffer(header.model_dump_json().encode(), np.uint8),
        ACTIONS: episodes.actions,
        ENDED: ended,
    }
    parts |= {ARRAY + name: values for name, values in arrays.items()}
    for k in range(episodes.n):
        parts[f"{MEMBER}{k}"] = np.frombuffer(episodes.batch.save_state(k), np.uint8)
    return npz_bytes(np.savez, **parts)


def restore_episodes(episodes: Episodes, state: bytes) -> tuple[Any, Flags]:
    """Continue from a saved state; return the observations and the mask (n,) of the members that have ended.

    Raises ValueError for a state that is damaged or that belongs to another environment.
    """
    if not isinstance(state, bytes):
        raise ValueError(f"state is {type(state).__name__}: must be bytes returned by save_state")
    try:
        parts = read_npz(state)
    except ValueError as error:
        raise ValueError(f"state: {error}") from None
    header = _header(parts, episodes)
    arrays, _ = task_state(episodes.task)
    expected = {ACTIONS: episodes.actions, ENDED: np.zeros(episodes.n, np.bool_)}
    expected |= {ARRAY + name: values for name, values in arrays.items()}
    for name, like in expected.items():
        found = parts.get(name)
        if found is None or found.shape != like.shape or found.dtype != like.dtype:
            given = "is missing" if found is None else f"{found.dtype} {found.shape}"
            raise ValueError(f"state: {name}: {given}: must be {like.dtype} {like.shape}")
    batch = episodes.batch
    members = [parts.get(f"{MEMBER}{k}", np.zeros(0, np.uint8)).tobytes() for k in range(episodes.n)]
    before = _definitions(batch), [batch.save_state(k) for k in range(episodes.n)]
    try:
        _put(batch, header.members, members)
    except ValueError:
        _put(batch, *before)
        raise
    for name in arrays:
        setattr(episodes.task, name, parts[ARRAY + name])
    for name, value in header.plain.items():
        setattr(episodes.task, name, value)
    for k, saved in enumerate(header.generators):
        episodes.generators[k], episodes.generator_seeds[k] = _generator(saved), saved.seed
    episodes.actions[...] = parts[ACTIONS]
    return episodes.resume(), parts[ENDED]


def _header(parts: dict[str, NDArray[Any]], episodes: Episodes) -> Header:
    text = parts.get(HEADER, np.zeros(0, np.uint8)).tobytes().decode(errors="replace")
    header = checked(Header, text)
    _, plain = task_state(episodes.task)
    own = {"task": type(episodes.task).__name__, "n": episodes.n, "normalise": episodes.normalise}
    for key, value in own.items():
        if getattr(header, key) != value:
            raise ValueError(f"state: {key} = {getattr(header, key)!r}: this environment has {value!r}")
    counts = {len(header.generators), len(header.members)}
    if counts != {episodes.n} or set(header.plain) != set(plain):
        raise ValueError(f"state: belongs to another {header.task}")
    return header


def _definitions(batch: Batch) -> list[Definition]:
    each = zip(batch.seeds, batch.parameters, batch.faults, strict=True)
    return [
        Definition(
            seed=seed,
            parameters={name: _plain(value) for name, value in parameters.items()},
            faults=[fault.model_dump(mode="json", exclude_none=True) for fault in faults],
        )
        for seed, parameters, faults in each
    ]


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


def _put(batch: Batch, members: list[Definition], states: list[bytes]) -> None:
    """Restart all members as defined, and continue each from its state. Raises ValueError."""
    batch.reset(
        seeds=[member.seed for member in members],
        parameters=[member.parameters for member in members],
        faults=[member.faults for member in members],
    )
    for k, state in enumerate(states):
        batch.restore_state(k, state)


def task_state(task: Task) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    """Return a task's arrays, and its numbers and strings, by name. Raises ValueError for lists, dicts and sets."""
    arrays: dict[str, NDArray[Any]] = {}
    plain: dict[str, Any] = {}
    for name, value in vars(task).items():
        if name in FIXED:
            continue
        where = f"{type(task).__name__}.{name}"
        if isinstance(value, np.ndarray):
            if value.dtype.kind not in "biufc":
                raise ValueError(f"{where}: {value.dtype} array: cannot be saved: must be numbers or bool")
            arrays[name] = value
        elif isinstance(value, np.generic):
            arrays[name] = np.asarray(value)
        elif isinstance(value, PLAIN):
            plain[name] = value
        elif isinstance(value, CONTAINERS):
            raise ValueError(f"{where} is {type(value).__name__}: cannot be saved: use an array with a row per member")
    return arrays, plain


def _saved_generator(episodes: Episodes, member: int) -> GeneratorState:
    generator = episodes.generators[member]
    if generator is None:
        raise ValueError("save_state: no episode has begun: reset() first")
    state: Any = generator.bit_generator.state
    rest = {key: state[key] for key in ("has_uint32", "uinteger")}
    return GeneratorState(seed=episodes.generator_seeds[member], **state["state"], **rest)


def _generator(saved: GeneratorState) -> np.random.Generator:
    generator, _ = np_random(0)
    rest = saved.model_dump(include={"has_uint32", "uinteger"})
    words = {"state": saved.state, "inc": saved.inc}
    generator.bit_generator.state = {"bit_generator": "PCG64", "state": words, **rest}
    return generator
