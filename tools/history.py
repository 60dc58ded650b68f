"""Keep a history of ratios: `python -m tools.history measure`, `check`, or `compare OLD NEW` for two commits.

Each ratio compares two rates that one benchmark measures in the same rounds, most of them with a peer's, so that it
depends little on the load. It does depend on the kind of processor. `measure` writes docs/benchmarks/COMMIT.json, which
includes the machine and its load; the site plots these files, and `python -m tools.measured` fills pages from the
newest. Before a release, `check` measures some of them, on a quiet machine, and fails if one has become worse by 15 %
on this kind of processor.
"""

from __future__ import annotations

import json
import os
import platform
import re
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import typer

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "docs" / "benchmarks"
PEERS = {
    "sonar": ["--pings", "100"],
    "dynamics": [],
    "camera": ["--threads", "1"],
    "imaging": [],
    "mapping": ["--only", "B"],
}
"""The benchmarks with a peer that tools/setup --dev installs, and the options that shorten them."""
CHECKED = ("sonar", "dynamics", "imaging")
WORSE, TRIES = 1.15, 5
"""The benchmarks that `check` runs; the factor by which the best of its tries may be worse. Single runs differed by 1.6
on a machine that its host slowed down for minutes at a time."""


class Ratio(NamedTuple):
    """A ratio: its place in a benchmark's JSON, its meaning, and whether higher is better."""

    path: tuple[str, ...]
    title: str
    more_is_better: bool


RATIOS = {
    "ping_embree": Ratio(("sonar", "ping/limit"), "pings along lanes, of the rate of Embree's rays alone", True),
    "ping_embree_scattered": Ratio(
        ("sonar", "ping_scattered/limit_scattered"),
        "pings at scattered places, of the rate of Embree's rays alone",
        True,
    ),
    "ping_bullet": Ratio(("sonar", "ping/bullet"), "pings, times as many as with Bullet's ray test", True),
    "step_bullet": Ratio(
        ("dynamics", "against_bare_bullet"), "steps in open water, of the rate of Bullet's bare step", True
    ),
    "bed_bullet": Ratio(
        ("dynamics", "above_bottom_against_bare_bullet"), "steps above the bed, of the rate of Bullet's bare step", True
    ),
    "engine_bullet": Ratio(
        ("dynamics", "bullet_engine_against_bare_bullet"),
        "steps with dynamics.engine: bullet, of the rate of Bullet's bare step",
        True,
    ),
    "waves_still": Ratio(("dynamics", "waves_against_still"), "steps in waves, of the rate in still water", True),
    "fleet_one": Ratio(("dynamics", "fleet_against_one"), "a step of one of 64 vehicles, times the cost of one", False),
    "ping_physics": Ratio(("sonar", "ping/physics"), "a ping in physics mode, times the cost in geometry mode", False),
    "ping_bent": Ratio(
        ("sonar", "physics/physics_bent"), "a ping with bent rays, times the cost with straight ones", False
    ),
    "sonar_picture_embree": Ratio(
        ("imaging", "picture/wide"), "a sonar's picture, times the cost of Embree's rays alone", False
    ),
    "picture_embree": Ratio(("camera", "against_bare"), "a picture, times the cost of Embree's rays alone", False),
    "geometry_embree": Ratio(
        ("camera", "geometry_against_bare"), "a picture's geometry, times the cost of Embree's rays alone", False
    ),
    "map_fine": Ratio(("mapping", "B 0.2", "bricks_1_ratio"), "a map of 0.2 m, times as fast as OctoMap", True),
    "map_coarse": Ratio(("mapping", "B 0.5", "bricks_1_ratio"), "a map of 0.5 m, times as fast as OctoMap", True),
    "map_portable": Ratio(
        ("mapping", "B 0.5", "portable_ratio"), "the same by the portable kernels, times as fast as OctoMap", True
    ),
}

app = typer.Typer(add_completion=False, help=__doc__)


@app.command()
def measure(rounds: Annotated[int, typer.Option(min=1, help="Rounds of each benchmark.")] = 7) -> None:
    """Measure this tree, whose sources must be committed, and write docs/benchmarks/COMMIT.json."""
    if _git(ROOT, "status", "--porcelain", "--", "cpp", "python", "tools/bench"):
        _refuse("cpp, python or tools/bench: differ from the last commit; commit them, so that the ratios have a name")
    commit, date = _git(ROOT, "log", "-1", "--format=%H %cI").split()
    subprocess.run([ROOT / "tools/setup", "--dev"], check=True)
    target = FOLDER / f"{commit[:12]}.json"
    entry: dict[str, Any] = {"commit": commit, "date": date, "machine": machine(), "rounds": rounds}
    before = os.getloadavg()[0]
    entry["ratios"] = ratios(ROOT, rounds)
    entry["load"] = {"before": round(before, 1), "after": round(os.getloadavg()[0], 1)}
    FOLDER.mkdir(exist_ok=True)
    target.write_text(json.dumps(entry, indent=1) + "\n")
    print(target)


@app.command()
def check(rounds: Annotated[int, typer.Option(min=1, help="Rounds of each benchmark.")] = 3) -> None:
    """Fail if this tree, as built, is slower than the last ratios kept for this kind of processor allow."""
    here = machine()
    kept = [entry for entry in entries(FOLDER) if entry["machine"] == here]
    if not kept:
        print(f"history: no ratios are kept for {here}: nothing to compare with")
        return
    then, best = kept[-1]["ratios"], dict[str, float]()
    for _ in range(TRIES):
        for name, value in ratios(ROOT, rounds, CHECKED).items():
            if name not in best or improvement(name, best[name], value) > 1.0:
                best[name] = value
        worse = [name for name, value in best.items() if improvement(name, then[name], value) * WORSE < 1.0]
        if not worse:
            break
    for name, value in best.items():
        print(f"history: {RATIOS[name].title}: {value:.3g}, kept {then[name]:.3g}{' WORSE' * (name in worse)}")
    if worse:
        _refuse(f"worse by more than {WORSE:g} than at {kept[-1]['commit'][:12]}: {', '.join(worse)}")


@app.command()
def compare(
    old: str,
    new: str,
    rounds: Annotated[int, typer.Option(min=1, help="How often each commit is measured, in turns.")] = 3,
) -> None:
    """Build two commits in build/compare and print their ratios; the measurements alternate.

    OLD and NEW are commits, or folders that tools/setup --dev has prepared.
    """
    if old == new:
        _refuse(f"{old}: given twice; name two commits")
    trees = {name: checkout(name) for name in (old, new)}
    found: dict[str, list[dict[str, float]]] = {name: [] for name in trees}
    for turn in range(rounds):
        for name, tree in trees.items():
            print(f"round {turn + 1} of {rounds}: {name}", file=sys.stderr)
            found[name].append(ratios(tree, 3))
    print("\n".join(table(found[old], found[new], old, new)))


def checkout(name: str) -> Path:
    """Return the folder of a commit, built with its own tools/setup, or the folder itself."""
    if (Path(name) / "tools/setup").exists():
        return Path(name).resolve()
    commit = _git(ROOT, "rev-parse", "--verify", "--quiet", f"{name}^{{commit}}")
    tree = ROOT / "build" / "compare" / commit[:12]
    if not tree.exists():
        _git(ROOT, "clone", "--quiet", "--no-checkout", str(ROOT), str(tree))
        _git(tree, "checkout", "--quiet", commit)
    subprocess.run([tree / "tools/setup", "--dev"], check=True)
    return tree


def ratios(tree: Path, rounds: int, benchmarks: Iterable[str] = PEERS) -> dict[str, float]:
    """Run benchmarks of a source tree that has been built, and return the ratios that they report."""
    results: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name in benchmarks:
            output = Path(folder) / f"{name}.json"
            options = [*PEERS[name], "--rounds", str(rounds), "--json", output]
            command = [tree / ".venv/bin/uwsim", "bench", name, *options]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL, cwd=folder)
            results[name] = json.loads(output.read_text())
    return {name: value for name, ratio in RATIOS.items() if (value := _at(results, ratio.path)) is not None}


def table(old: list[dict[str, float]], new: list[dict[str, float]], *names: str) -> list[str]:
    """Return a line per ratio: the medians of both commits, and the improvement by the new one, with its spread."""
    width = max(len(ratio.title) for ratio in RATIOS.values())
    lines = [f"{'':{width}} {names[0][:12]:>12} {names[1][:12]:>12}  new is better by (lowest to highest round)"]
    for name, ratio in RATIOS.items():
        pairs = [(a[name], b[name]) for a, b in zip(old, new, strict=True) if name in a and name in b]
        if not pairs:
            lines.append(f"{ratio.title:{width}} one of the commits does not measure it")
            continue
        gains = sorted(improvement(name, a, b) for a, b in pairs)
        before, after = (statistics.median(values) for values in zip(*pairs, strict=True))
        spread = f"{statistics.median(gains):.2f} ({gains[0]:.2f} to {gains[-1]:.2f})"
        lines.append(f"{ratio.title:{width}} {before:12.3g} {after:12.3g}  {spread}")
    return lines


def improvement(name: str, old: float, new: float) -> float:
    """Return by which factor a ratio has become better; below 1 if it has become worse."""
    return new / old if RATIOS[name].more_is_better else old / new


def entries(folder: Path) -> list[dict[str, Any]]:
    """Return what has been measured, from the oldest commit to the newest."""
    return sorted((json.loads(path.read_text()) for path in folder.glob("*.json")), key=lambda entry: entry["date"])


def machine() -> dict[str, Any]:
    """Return the processor's name, the instruction set of the kernels and the number of cores."""
    from uwsim._core import instruction_set

    model = re.search(r"^model name\s*:\s*(.*)$", Path("/proc/cpuinfo").read_text(), re.MULTILINE)
    processor = model[1] if model else platform.machine()
    return {"processor": processor, "instruction_set": instruction_set(), "cores": os.cpu_count()}


def machine_text(cpu: dict[str, Any]) -> str:
    """Return a machine in a few words. Entries before November 28, 2026 do not name the instruction set."""
    kind = f" ({cpu['instruction_set']})" if "instruction_set" in cpu else ""
    return f"{cpu['processor']}{kind}, {cpu['cores']} cores"


def _at(results: Any, path: tuple[str, ...]) -> float | None:
    for key in path:
        results = results.get(key, {})
    return None if results == {} else float(f"{results:.4g}")


def _git(folder: Path, *arguments: str) -> str:
    done = subprocess.run(["git", "-C", folder, *arguments], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        _refuse(f"git {' '.join(arguments)}: {done.stderr.strip() or 'no such commit'}")
    return done.stdout.strip()


def _refuse(why: str) -> None:
    print(f"history: {why}", file=sys.stderr)
    sys.exit(2)


if __name__ == "__main__":
    app()
