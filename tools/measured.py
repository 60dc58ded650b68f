"""Keep the figures of speed equal everywhere: `python -m tools.measured write`; `survey`, `commands` measure first.

docs/inside/measured.json and the newest file of docs/benchmarks are their one home. In the pages below, the word or the
code in backticks before a comment such as <!--survey.times--> is the value of that name.
"""

from __future__ import annotations

import json
import re
import statistics
import subprocess
import sys
import tempfile
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from tools.history import FOLDER, entries, machine, machine_text

ROOT = Path(__file__).resolve().parents[1]
VALUES = ROOT / "docs/inside/measured.json"
ROUNDS = 3
WITH_SPEED = [
    ROOT / name for name in ("README.md", "docs/index.md", "docs/inside/performance.md", "docs/paper/paper.md")
]
"""The pages that state how many times faster than real time a survey is."""
PAGES = [*WITH_SPEED, ROOT / "docs/guides/coming-from.md"]
MARKED = re.compile(r"(`[^`]*`|[\w.]+)<!--(\w+)\.(\w+)-->")


def filled(text: str, values: dict[str, dict[str, Any]]) -> str:
    """Return a page with every marked word replaced by its value. Raises KeyError for an unknown name."""

    def value(match: re.Match[str]) -> str:
        new = f"{values[match[2]][match[3]]}"
        return f"{f'`{new}`' if match[1].startswith('`') else new}<!--{match[2]}.{match[3]}-->"

    return MARKED.sub(value, text)


def all_values() -> dict[str, dict[str, Any]]:
    """Return the values of every name: those of measured.json, and the newest ratios."""
    newest = entries(FOLDER)[-1]
    load = newest["load"]
    about = {
        "commit": newest["commit"][:8],
        "date": newest["date"][:10],
        "machine": machine_text(newest["machine"]),
        "load": f"{load['before']:g} to {load['after']:g}",
    }
    ratios = {name: f"{value:.3g}" for name, value in newest["ratios"].items()}
    return {**json.loads(VALUES.read_text()), "ratios": ratios | about}


def measure_commands(values: dict[str, Any]) -> None:
    """Replace the wall time of the whole command with either report, over the faster flight's; medians."""
    shares: dict[str, list[float]] = {"json": [], "full": []}
    for _ in range(ROUNDS):
        whole_s, flight_s = {}, []
        for report in shares:
            with tempfile.TemporaryDirectory() as folder:
                begun_s = time.perf_counter()
                command = ["uwsim", "survey", "lake", "--voxel", "0.2", "--out", folder, "--report", report]
                subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                whole_s[report] = time.perf_counter() - begun_s
                flight_s.append(json.loads((Path(folder) / "summary.json").read_text())["wall_s"])
        for report, found in shares.items():
            found.append(whole_s[report] / min(flight_s))
    values |= {report: f"{statistics.median(found):.2g}" for report, found in shares.items()}
    values |= {scenario: f"{start_share(scenario):.2g}" for scenario in ("lake", "pool")}
    values |= {"date": f"{datetime.now(UTC):%Y-%m-%d}", "machine": machine_text(machine())}


def start_share(scenario: str) -> float:
    """Return the wall time from starting Python to a scenario's first step, over that until NumPy is imported."""
    shares = []
    for _ in range(3 * ROUNDS):
        spent_s = []
        for code in (f"import uwsim; uwsim.Simulator({scenario!r}).step()", "import numpy"):
            begun_s = time.perf_counter()
            subprocess.run([sys.executable, "-c", code], check=True)
            spent_s.append(time.perf_counter() - begun_s)
        shares.append(spent_s[0] / spent_s[1])
    return statistics.median(shares)


def measure_survey(values: dict[str, Any]) -> None:
    """Replace the survey's figures by those of its command, run here and now."""
    with tempfile.TemporaryDirectory() as folder:
        found = Path(folder) / "survey.json"
        subprocess.run([*values["command"].split(), "--json", found], check=True)
        result = json.loads(found.read_text())
    values |= {
        "minutes": round(result["simulated_s"] / 60.0),
        "seconds": round(result["wall_s"], 1),
        "times": int(float(f"{result['real_time_factor']:.2g}")),
        "date": f"{datetime.now(UTC):%Y-%m-%d}",
        "machine": machine_text(machine()),
    }


MEASURES = {"survey": measure_survey, "commands": measure_commands}


def main() -> None:
    """Measure if asked to, and write the pages."""
    name = sys.argv[-1]
    if len(sys.argv) != 2 or name not in (*MEASURES, "write"):
        sys.exit(__doc__)
    if name in MEASURES:
        values = json.loads(VALUES.read_text())
        MEASURES[name](values.setdefault(name, {}))
        VALUES.write_text(json.dumps(values, indent=1) + "\n")
    for page in PAGES:
        page.write_text(filled(page.read_text(), all_values()))


if __name__ == "__main__":
    main()
