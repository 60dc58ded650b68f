"""Measures wall time by stage. Blocks may be nested; time is counted only for the innermost block."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")


class WallTimer:
    """Accumulates wall time by stage. Only one thread may time a given stage."""

    def __init__(self, stages: Iterable[str] = ()) -> None:
        self.wall_s = dict.fromkeys(stages, 0.0)
        self._measurements: dict[str, Measurement] = {}
        self._inner = _Inner()

    def measure(self, stage: str) -> Measurement:
        """Return a context manager that adds its block's wall time to a stage. Do not nest blocks of the same stage."""
        measurement = self._measurements.get(stage)
        if measurement is None:
            measurement = self._measurements[stage] = Measurement(self.wall_s, stage, self._inner)
        return measurement

    def timed(self, stage: str, function: Callable[P, T]) -> Callable[P, T]:
        """Wrap a function so that the time of its calls is added to a stage."""
        measurement = self.measure(stage)

        def call(*args: P.args, **kwargs: P.kwargs) -> T:
            with measurement:
                return function(*args, **kwargs)

        return call


class _Inner(threading.local):
    """Per-thread state. took_s: a list with the total time [s] of the finished blocks inside the current block."""

    def __init__(self) -> None:
        self.took_s = [0.0]


class Measurement:
    """Adds the time of a `with` block, excluding nested blocks, to a stage.

    This is a class because a generator-based context manager would be slower, and each ping uses several measurements.
    """

    __slots__ = ("_before_s", "_inner", "_stage", "_start_s", "_took_s", "_wall_s")

    def __init__(self, wall_s: dict[str, float], stage: str, inner: _Inner) -> None:
        self._wall_s, self._stage, self._inner = wall_s, stage, inner
        wall_s.setdefault(stage, 0.0)
        self._took_s: list[float] | None = None

    def __enter__(self) -> None:
        if (took_s := self._took_s) is None:
            took_s = self._took_s = self._inner.took_s  # looked up once, because a single thread times each stage
        self._before_s, took_s[0] = took_s[0], 0.0
        self._start_s = time.perf_counter()

    def __exit__(self, *_: object) -> None:
        took_s = time.perf_counter() - self._start_s
        inner_s = self._took_s
        assert inner_s is not None
        self._wall_s[self._stage] += took_s - inner_s[0]
        inner_s[0] = self._before_s + took_s
