"""Parts that the benchmarks share: alternating rounds, medians and ratios, tables with goals, and native peers."""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from uwsim import _core

console = Console()


def alternated(
    cases: Mapping[Any, Callable[[], Any]], rounds: int, *, warm_up: bool = False, what: str = ""
) -> dict[Any, list[Any]]:
    """Measure all cases in each round, so that other load affects all of them equally; return each case's values.

    warm_up: precede the rounds by one that does not count. After the first round, the time that is left is shown, or
    printed once where there is no terminal.
    """
    found: dict[Any, list[Any]] = {name: [] for name in cases}
    begun_s, left = time.monotonic(), ""
    for turn in range(-warm_up, rounds):
        with console.status(f"{what}round {turn + 1} of {rounds}{left}"):
            for name, case in cases.items():
                value = case()
                if turn >= 0:
                    found[name].append(value)
        done, remaining = turn + warm_up + 1, rounds - turn - 1
        left_s = remaining * (time.monotonic() - begun_s) / done
        left = f", about {left_s:.0f} s left"
        if done == 1 and remaining and left_s > 5.0 and not console.is_terminal:
            console.print(f"{what}{rounds} rounds, about {left_s:.0f} s")
    return found


PlotFile = Annotated[Path | None, typer.Option(help="Write this figure, a PNG. By default none is drawn.")]
"""The option of a benchmark that can draw what it has measured."""


def medians(found: Mapping[Any, Iterable[float]]) -> dict[Any, float]:
    """Return the median of each case."""
    return {name: statistics.median(values) for name, values in found.items()}


def ratio(one: Iterable[float], other: Iterable[float]) -> float:
    """Return the median of the per-round ratios of two cases."""
    return statistics.median(a / b for a, b in zip(one, other, strict=True))


def spent_s(call: Callable[[], object], clock: Callable[[], float] = time.process_time) -> float:
    """Return the time that a call takes."""
    begun = clock()
    call()
    return clock() - begun


def new_table(title: str, *columns: str, texts: int = 1) -> Table:
    """Return a table whose first columns hold texts, and whose other columns hold numbers."""
    table = Table(title=title, title_justify="left")
    for k, column in enumerate(columns):
        table.add_column(column, justify="left" if k < texts else "right")
    return table


def goal_cells(value: float | None, goal: float | None, *, at_most: bool = False) -> tuple[str, str]:
    """Return a goal, and whether the value meets it; empty without either."""
    if value is None or goal is None:
        return "", ""
    met = value <= goal if at_most else value >= goal
    return f"{goal:,g}", "[green]yes[/]" if met else "[red]no[/]"


def goals_table(title: str, results: Mapping[str, float], goals: Mapping[str, tuple[str, float]]) -> Table:
    """Return a table of values, and of the goals of some: "<=" or ">=", and the limit."""
    table = new_table(title, "result", "measured", "goal", "met")
    for name, value in results.items():
        sign, goal = goals.get(name, ("", None))
        limit, met = goal_cells(value, goal, at_most=sign == "<=")
        table.add_row(escape(name), f"{value:.3g}" if value < 1e4 else f"{value:.0f}", f"{sign} {limit}", met)
    return table


def native_program(name: str) -> Path | None:
    """Return the path of a native peer, which is installed with the compiled module; report one that is missing."""
    program = Path(_core.__file__).parent / "bench" / "native" / name
    if program.is_file():
        return program
    console.print(f"without {name}: not installed with the package (run tools/setup)")
    return None


class NativePeer:
    """A program that reads its input once, and casts all rays at each request."""

    def __init__(self, *command: object) -> None:
        self._process = subprocess.Popen(
            [str(word) for word in command], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        assert self._process.stdin is not None and self._process.stdout is not None
        self._requests, self._answers = self._process.stdin, self._process.stdout
        self._answers.readline()  # it is ready

    def times_s(self) -> list[float]:
        """Cast all rays; return the times that the program prints."""
        self._requests.write("\n")
        self._requests.flush()
        return [float(word) for word in self._answers.readline().split()]

    def close(self) -> None:
        """Stop the program."""
        self._process.communicate()


def child(file: str, *arguments: object) -> subprocess.Popen[str]:
    """Start a benchmark's file as a separate process, which prints its results as JSON."""
    command = [sys.executable, file, *map(str, arguments)]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def result_of(process: subprocess.Popen[str], limit_s: float | None = 300.0) -> Any:
    """Return the results of a process when it has ended."""
    return json.loads(process.communicate(timeout=limit_s)[0])


def wait_for(condition: Callable[[], object], limit_s: float = 60.0) -> None:
    """Wait until a condition is true. Raises TimeoutError."""
    deadline_s = time.monotonic() + limit_s
    while not condition():
        if time.monotonic() > deadline_s:
            raise TimeoutError("the other processes did not come, or did not do what is measured")
        time.sleep(0.01)
