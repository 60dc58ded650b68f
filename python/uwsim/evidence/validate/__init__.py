"""Validation: comparisons of the simulator with closed forms and published data, as tables and curves.

A suite is a module with a `run() -> list[Check]` function and an entry in `uwsim.evidence.suites`. Those in RECORDED
take the folder of recorded data, which is not part of uwsim. Whatever a native test states is not asked here again.
"""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator, Sequence
from contextvars import copy_context
from importlib import import_module
from itertools import repeat
from pathlib import Path

from uwsim.evidence.suites import ON_REQUEST, RECORDED, SUITES
from uwsim.evidence.validate.check import Check
from uwsim.evidence.validate.flights import ENGINE
from uwsim.evidence.validate.report import draw_checks

__all__ = ["ON_REQUEST", "RECORDED", "SUITES", "run_suite", "run_suites"]


def run_suite(name: str, out: Path | None = None, data: Path | None = None, engine: str = "uwsim") -> list[Check]:
    """Run a suite and return its checks; draw its curves into the folder `out`. data: folder of recorded data.

    engine: the `dynamics.engine` used by the `dynamics` suite. Raises ValueError for an unknown name, and for `reality`
    and `flights` without data.
    """
    if name not in SUITES:
        raise ValueError(f"validation '{name}': unknown; there are: {', '.join(SUITES)}")
    run = import_module(SUITES[name]).run
    checks: list[Check] = copy_context().run(_run_with, engine, run, *([data] if name in RECORDED else []))
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        draw_checks(checks, out, name)
    return checks


def _run_with(engine: str, run: Callable[..., list[Check]], *arguments: Path | None) -> list[Check]:
    ENGINE.set(engine)
    return run(*arguments)


def run_suites(
    names: Sequence[str], out: Path | None, jobs: int, data: Path | None = None, engine: str = "uwsim"
) -> Iterator[tuple[str, list[Check]]]:
    """Yield suite names and checks in the given order; see run_suite(). jobs: number of parallel processes.

    The worker processes end together with the iterator.
    """
    if jobs == 1:
        yield from ((name, run_suite(name, out, data, engine)) for name in names)
        return
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import active_children, get_context

    with ProcessPoolExecutor(jobs, get_context("spawn"), _leave_ctrl_c_to_the_parent) as pool:
        try:
            yield from zip(names, pool.map(run_suite, names, repeat(out), repeat(data), repeat(engine)), strict=False)
        except BaseException:
            for process in active_children():
                process.terminate()
            raise


def _leave_ctrl_c_to_the_parent() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
