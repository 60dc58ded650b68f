"""Kill a recording process at random times, and check the remaining recording each time.

    .venv/bin/python tools/soak/recording.py --kills 25

After each kill -9 the recording must open, its messages must be those of a run without gaps, at most LOSS_S of wall
time may be missing, and its replay must give the same bytes. Exits with 1 if one of these rules is broken.
"""

from __future__ import annotations

import random
import signal
import subprocess
import sys
import tempfile
import time
from itertools import pairwise
from pathlib import Path
from typing import Annotated

import typer

from uwsim import recording
from uwsim.recording.replay import replay

LOSS_S = 2.5  # one second between flushes, plus the delay of a busy machine
CHILD = """
import sys, time
from uwsim.live import LiveSimulator
from uwsim.recording import Recorder
with LiveSimulator("lake", speed=1.0) as live, Recorder(live, sys.argv[1], without=["camera/*", "image*"]):
    live.rov.undock()
    print("recording", flush=True)
    step = 0
    while True:
        live.rov.set_effort(surge=0.5, yaw=0.3 * (step % 3 - 1))
        step += 1
        live.clock.wait(0.2)
        print(live.simulator.time_ns, flush=True)
"""


def main(
    kills: Annotated[int, typer.Option(min=1, help="Number of kills.")] = 25,
    longest: Annotated[float, typer.Option(help="The latest moment of a kill [s].")] = 8.0,
    seed: Annotated[int, typer.Option(help="The seed of the moments.")] = 0,
) -> None:
    """Kill, check and repeat."""
    moments = random.Random(seed)
    worst_s, failures = 0.0, 0
    with tempfile.TemporaryDirectory() as folder:
        for number in range(kills):
            path = Path(folder) / f"{number}.mcap"
            after_s = moments.uniform(0.0, longest)
            reached_ns = killed_run(path, after_s)
            error, lost_s = verdict(path, reached_ns)
            worst_s = max(worst_s, lost_s)
            failures += error is not None
            typer.echo(f"{number + 1:3d}: killed after {after_s:4.1f} s, {lost_s:.2f} s lost: {error or 'well'}")
            path.unlink(missing_ok=True)
    typer.echo(f"{kills - failures} of {kills} well; {worst_s:.2f} s lost at worst")
    raise typer.Exit(1 if failures else 0)


def killed_run(path: Path, after_s: float) -> int:
    """Record in another process and kill it; return the simulated time that it reached."""
    process = subprocess.Popen([sys.executable, "-c", CHILD, str(path)], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    process.stdout.readline()
    time.sleep(after_s)
    process.send_signal(signal.SIGKILL)
    lines = process.stdout.read().split()
    process.wait()
    return int(lines[-1]) if lines else 0


def verdict(path: Path, reached_ns: int) -> tuple[str | None, float]:
    """Return a description of a recording's faults, and the time of the run that is missing from it [s]."""
    opened = recording.open(path)
    times = [recorded.time_ns for recorded in opened.messages("odom")]
    lost_s = max(1e-9 * (reached_ns - (times[-1] if times else 0)), 0.0)
    gaps = {later - earlier for earlier, later in pairwise(times[1:])}
    if gaps - {20_000_000}:
        return f"odom has gaps of {sorted(gaps)} ns", lost_s
    if lost_s > LOSS_S:
        return "too much is lost", lost_s
    return replay(opened).difference, lost_s


if __name__ == "__main__":
    typer.run(main)
