"""The table of results of the named benchmarks, from the files in docs/submissions."""

import json
import statistics
from pathlib import Path
from typing import Any

from uwsim.flight.benchmark import FOLDER, Benchmark, load_benchmark
from uwsim.flight.paired import MORE_IS_BETTER
from uwsim.scenario.read.assets import packaged_names

SUBMISSIONS = Path(__file__).resolve().parents[2] / "docs/submissions"
HEAD = """# Results of the benchmarks

Medians over held-out seeds of each [named benchmark](../guides/compare.md#named-benchmarks), best first by the first
value. Each row comes from a file in `docs/submissions`, written by `uwsim compare --benchmark NAME --held-out`.
"""


def results_page() -> str:
    """Return the page, with a table for each benchmark."""
    submitted = [json.loads(path.read_text()) for path in sorted(SUBMISSIONS.glob("*.json"))]
    return "\n".join([HEAD, *(_section(load_benchmark(name), submitted) for name in packaged_names(FOLDER))])


def _section(benchmark: Benchmark, submitted: list[dict[str, Any]]) -> str:
    ours = [each for each in submitted if (each["benchmark"], each["version"]) == (benchmark.name, benchmark.version)]
    rows: dict[tuple[str, str], list[float]] = {}
    notes: dict[tuple[str, str], str] = {}
    for each in ours:
        for mission, digest in each["missions"].items():
            flown = [row for row in each["rows"] if row["mission"] == mission]
            rows[mission, digest] = [statistics.median(row[value] for row in flown) for value in benchmark.values]
            notes[mission, digest] = f"{len(flown)} | {each['uwsim']}, {each['build'][:8]}"
    first = benchmark.values[0]
    order = sorted(rows, key=lambda key: rows[key][0], reverse=MORE_IS_BETTER[first])
    lines = [
        f"| {mission} | {' | '.join(map(_short, rows[mission, digest]))} | {notes[mission, digest]} |"
        for mission, digest in order
    ]
    head = f"| mission | {' | '.join(f'`{value}`' for value in benchmark.values)} | seeds | uwsim, build |"
    rule = f"|{'---|' * (len(benchmark.values) + 3)}"
    return "\n".join([f"## {benchmark.name}\n\n{benchmark.task}\n", head, rule, *lines, ""])


def _short(value: float) -> str:
    """Return a value with three digits or, from 1000 on, all that are before the point."""
    return f"{value:.0f}" if abs(value) >= 1000 else f"{value:.3g}"
