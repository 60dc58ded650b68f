"""Kill surveys, missions, sweeps and fleets at random times, fly them on, and compare their results.

    .venv/bin/python tools/soak/kill.py --minutes 10

A kill is a kill -9 of the command and of all its workers. Half of the kill times are uniform over the job; a quarter
are within milliseconds of a file being written (autosaves, renames, results), and a quarter while the final results are
written. After each kill an existing map must open; a sweep or a fleet is resumed, a flight is flown again, and killed
again. The final results must be byte-identical to those of an uninterrupted job. Exits with 1 if one of these rules is
broken.
"""

from __future__ import annotations

import hashlib
import itertools
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, NamedTuple

import pandas as pd
import typer

from uwsim.mapping import OccupancyMap

UWSIM = [sys.executable, "-c", "from uwsim.cli import main; main()"]
POLL_S = 0.001
NOTHING_SAVED = ("there is no sweep", "there is no fleet")
SWEEP = """\
scenario: pool
mission: MISSION
vary: {mission.depth_m: {choices: [1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.2, 2.4]}}
seeds: {first: 3}
"""
MISSION = "from uwsim.examples.m01_hello_dive import mission\n__all__ = ['mission']\n"


class Work(NamedTuple):
    """A job to kill. options: those of the command, except --out and --resume. digest: hashes a folder's results."""

    name: str
    options: tuple[str, ...]
    digest: Callable[[Path], str]


def digest_of_files(out: Path) -> str:
    """Return the hash of map and tracks."""
    files = [out / "map.bt", *sorted(out.glob("track-*.csv"))]
    return hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest()


def digest_of_table(out: Path) -> str:
    """Return the hash of all rows, ignoring their wall times."""
    table = pd.read_parquet(out / "runs.parquet")
    return hashlib.sha256(table.drop(columns=["run_wall_s", "flight_wall_s"]).to_csv().encode()).hexdigest()


def works(folder: Path) -> list[Work]:
    """Return one job of each kind, with its files in `folder`."""
    mission = folder / "dive.py"
    mission.write_text(MISSION)
    sweep = folder / "sweep.yaml"
    sweep.write_text(SWEEP.replace("MISSION", str(mission)))
    saved = ("--autosave", "0.1")
    return [
        Work("survey", ("pool", "--voxel", "0.1", "--seed", "3", *saved), digest_of_files),
        Work("run", (str(mission), "--scenario", "lake", "--map", "--seed", "3", *saved), digest_of_files),
        Work("sweep", (str(sweep), "--workers", "2"), digest_of_table),
        Work("fleet", ("pool", "--tile", "5", "--voxel", "0.3", "--workers", "2"), digest_of_files),
    ]


def start(work: Work, out: Path, *, resume: bool) -> subprocess.Popen[str]:
    """Start a command as the leader of its own process group."""
    command = [*UWSIM, work.name, *work.options, *["--resume"] * resume, "--out", str(out)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)


def wait_for_the_moment(process: subprocess.Popen[str], out: Path, whole_s: float, draw: random.Random) -> str:
    """Wait for the time of the kill or the end of the process; return the kind of time."""
    kind = draw.choice(["any", "any", "write", "end"])
    began_s = time.monotonic()
    after_s = draw.uniform(0.0, whole_s) if kind != "end" else draw.uniform(0.7, 1.0) * whole_s
    while process.poll() is None and time.monotonic() - began_s < after_s:
        time.sleep(POLL_S)
    while kind == "write" and process.poll() is None:  # until there is a temporary file, which is renamed when complete
        if any(name.startswith(".") for _, _, files in os.walk(out) for name in files):
            break
        time.sleep(POLL_S)
    if kind == "write":
        time.sleep(draw.uniform(0.0, 0.01))
    return kind


def done_whole(work: Work, folder: Path) -> tuple[str, float]:
    """Run the job undisturbed; return the digest of its results, and its duration [s]."""
    out = folder / f"{work.name}-whole"
    shutil.rmtree(out, ignore_errors=True)
    began_s = time.monotonic()
    process = start(work, out, resume=False)
    _, errors = process.communicate()
    if process.returncode != 0:
        sys.exit(f"{work.name}: ends with {process.returncode}: {errors}")
    return work.digest(out), time.monotonic() - began_s


def attack(work: Work, out: Path, took_s: float, draw: random.Random, kills: int) -> tuple[list[str], str]:
    """Kill the job up to `kills` times, then let it finish; return the kinds of kill times, and "" or a fault."""
    kinds: list[str] = []
    resume = False
    while True:
        process = start(work, out, resume=resume)
        if len(kinds) < kills:
            kind = wait_for_the_moment(process, out, took_s, draw)
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)  # its workers as well
                process.communicate()
                kinds.append(kind)
                resume = work.name in ("sweep", "fleet")
                if (out / "map.bt").exists():
                    OccupancyMap.read(out / "map.bt")  # raises an error if the file is damaged
                continue
        _, errors = process.communicate()
        if not resume or not any(words in errors for words in NOTHING_SAVED):
            return kinds, "" if process.returncode == 0 else f"ends with {process.returncode}: {errors.strip()[-300:]}"
        if (out / "map.bt").exists() or (out / "runs.parquet").exists():  # killed after its last save was removed
            return kinds, ""
        shutil.rmtree(out, ignore_errors=True)  # killed before the first save
        resume = False


def main(
    minutes: Annotated[float, typer.Option(min=0.1, help="How long new jobs are begun [min].")] = 10.0,
    each: Annotated[int, typer.Option(min=1, help="Maximum number of kills until a job may end.")] = 5,
    seed: Annotated[int, typer.Option(help="The seed of the moments.")] = 0,
    only: Annotated[str, typer.Option(help="Only survey, run, sweep or fleet.")] = "",
) -> None:
    """Kill, check, go on, compare and repeat."""
    draw = random.Random(seed)
    moments: Counter[str] = Counter()
    failures, ends_s = 0, time.monotonic() + 60.0 * minutes
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        todo = [work for work in works(folder) if only in ("", work.name)]
        if not todo:
            raise typer.BadParameter(f"'{only}' is none of survey, run, sweep, fleet", param_hint="--only")
        first: dict[str, str] = {}
        for work in itertools.cycle(todo):
            out = folder / "killed"
            shutil.rmtree(out, ignore_errors=True)
            # measured each time: on a machine that has become faster, kills would come too late
            digest, took_s = done_whole(work, folder)
            kinds, wrong = attack(work, out, took_s, draw, draw.randint(1, each))
            if not wrong and work.digest(out) != digest:
                wrong = "other bytes than of an uninterrupted job"
            if first.setdefault(work.name, digest) != digest:
                wrong = "other bytes, though it was not killed"
            moments.update(kinds)
            failures += bool(wrong)
            typer.echo(
                f"{moments.total():4d} {work.name}: killed at {', '.join(kinds) or 'no moment'}: {wrong or 'well'}"
            )
            if time.monotonic() > ends_s:
                break
    typer.echo(f"{moments.total()} kills ({dict(moments)}), {failures} failures")
    raise typer.Exit(bool(failures))


if __name__ == "__main__":
    typer.run(main)
