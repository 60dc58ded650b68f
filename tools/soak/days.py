"""Eight simulated days of surveys, pings, images and missions in one process, while it serves a few clients.

    .venv/bin/python tools/soak/days.py [--days 8] [--minutes 60] [--json FILE]

A lap of 1.5 simulated hours takes about 22 s of processor time: surveys, `uwsim scenario fingerprint`, a mission that
maps, 10 minutes with a ping each second, and idle flight. Each lap's output must be byte-identical to the first's. At
the same time, a rosbridge server with its own simulator serves the typical clients of rosbridge.py on the wall clock.

The exit code is 1 if memory grew by more than 2 % (straight line), processor time without the server's drifted by more
than 5 % (medians of the first and last third), bytes differ, or the number of threads or open files rose. The first
fifth of the laps, in which these values settle, is ignored.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import io
import json
import signal
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from steady import child, drift, ended, growth, open_files, peak_mb, trimmed_mb, verdict

import uwsim
from uwsim.bridges import RosbridgeServer
from uwsim.cli.run_live import keep_threads_moving
from uwsim.evidence.fingerprint import fingerprint
from uwsim.examples.m01_hello_dive import mission
from uwsim.live import LiveSimulator

DAY_S, HOUR_S = 86_400.0, 3600.0
LAP_H, POOL_SURVEYS, PINGS = 1.5, 5, 600
MEMORY, PACE, SETTLING = 0.02, 0.05, 0.2
LAPS_MIN = 10  # fewer laps are not conclusive


class Laps:
    """Fly laps; all results go into digests, one for each part."""

    def __init__(self, folder: Path, lap_s: float) -> None:
        self._folder, self._lap_s = folder, lap_s
        self._idle = uwsim.Simulator("lake", seed=7, threads=1)
        self._start = self._idle.save_state()

    def fly(self) -> dict[str, str]:
        """Fly a lap; return its digests."""
        digests: dict[str, str] = {}
        flown_s = survey("lake", self._folder, digests)
        flown_s += sum(survey("pool", self._folder, digests) for _ in range(POOL_SURVEYS))
        digests["fingerprint"] = fingerprint("lake", seed=7, threads=1).whole
        flown_s += 20.0  # two runs of 10 s
        dive = uwsim.fly(mission, "lake", map=True, seed=7, threads=1)
        assert dive.occupancy is not None
        digests["mission"] = hashlib.sha256(dive.occupancy.to_bytes("bt")).hexdigest()
        sim, seen = self._idle, hashlib.sha256()
        sim.restore_state(self._start)
        sim.rov.undock()
        sim.rov.set_effort(surge=0.3, yaw=0.1)
        for _ in range(PINGS):
            sim.advance(1.0)
            seen.update(sim.rov.sonar.ping().ranges_m)
        sim.advance(self._lap_s - flown_s - dive.simulated_s - PINGS)
        seen.update(np.concatenate([sim.rov.pose.position_world_m, sim.rov.pose.orientation_xyzw]))
        return digests | {"flight": seen.hexdigest()}


def survey(scenario: str, folder: Path, digests: dict[str, str]) -> float:
    """Fly a survey without output; return its simulated time [s]."""
    nowhere = io.StringIO()
    with contextlib.redirect_stdout(nowhere), contextlib.redirect_stderr(nowhere):
        record = uwsim.run_survey(scenario, folder / scenario, seed=7, threads=1, report="none")
    found = hashlib.sha256((folder / scenario / "map.bt").read_bytes()).hexdigest()
    if digests.setdefault(scenario, found) != found:
        digests[scenario] = "differs within one lap"
    return float(record.simulated_s)


def sample(laps: Laps, lap_s: float) -> dict[str, Any]:
    """Fly a lap; return its cost and the memory in use after it."""
    began_s = time.monotonic()
    cpu_s, digests = time.thread_time(), laps.fly()  # one thread; those of the server do not count
    cpu_s, wall_s = time.thread_time() - cpu_s, time.monotonic() - began_s
    return {
        "simulated_s": lap_s,
        "wall_s": wall_s,
        "memory_mb": trimmed_mb(),
        "objects": sys.getallocatedblocks(),
        "peak_mb": peak_mb(),
        "cpu_s_per_h": HOUR_S * cpu_s / lap_s,
        "threads": len(list(Path("/proc/self/task").iterdir())),
        "files": open_files(),
        "digests": digests,
    }


def fly_days(days: float, minutes: float, lap_s: float, live: LiveSimulator) -> list[dict[str, Any]]:
    """Fly laps until the days or the minutes have elapsed; print a line for each."""
    ends_s = time.monotonic() + 60.0 * minutes
    samples: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory() as name:
        laps = Laps(Path(name), lap_s)
        while len(samples) < days * DAY_S / lap_s and time.monotonic() < ends_s:
            live.reset()  # the clients' vehicle and map restart
            now = sample(laps, lap_s) | {"served": live.factor, "commands": len(live.log)}
            samples.append(now)
            other = [part for part, found in now["digests"].items() if found != samples[0]["digests"][part]]
            numbers = ", ".join(f"{name} {value:.5g}" for name, value in now.items() if name != "digests")
            differing = f"bytes of {', '.join(other)} DIFFER" if other else "bytes same"
            print(f"{len(samples) * lap_s / DAY_S:.2f} days: {numbers}, {differing}", flush=True)
    return samples


def wrongs(samples: list[dict[str, Any]]) -> list[str]:
    """Return the quantities that broke a rule."""
    if len(samples) < LAPS_MIN:
        return [f"{len(samples)} laps are too few to judge by"]
    judged = {
        "memory": growth([each["memory_mb"] for each in samples], SETTLING),
        "pace": drift([each["cpu_s_per_h"] for each in samples], SETTLING),
    }
    print(", ".join(f"{name} {share:+.2%}" for name, share in judged.items()))
    wrong = ["memory"] if not judged["memory"] <= MEMORY else []
    wrong += ["pace"] if not abs(judged["pace"]) <= PACE else []
    wrong += [name for name in ("threads", "files") if drift([each[name] for each in samples], SETTLING) > 0.0]
    return wrong + (["bytes"] if any(each["digests"] != samples[0]["digests"] for each in samples) else [])


def main() -> int:
    """Fly; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--days", type=float, default=8.0, help="maximum simulated days")
    parser.add_argument("--minutes", type=float, default=60.0, help="maximum wall time [min]")
    parser.add_argument("--json", type=Path, help="also write the samples to this file")
    options = parser.parse_args()
    keep_threads_moving()
    with LiveSimulator(uwsim.Simulator("lake", threads=1)) as live, RosbridgeServer(live) as server:
        seconds = 60.0 * options.minutes + 3600.0
        process = child(str(Path(__file__).with_name("rosbridge.py")), "clients", server.url, seconds)
        signal.signal(signal.SIGTERM, signal.default_int_handler)  # the clients end with this process
        try:
            samples = fly_days(options.days, options.minutes, HOUR_S * LAP_H, live)
            gone = process.poll() is not None
        finally:
            ended(process)
        time.sleep(5.0)
        left, error = len(server.sessions), live.error
    flown = f"{len(samples) * LAP_H / 24:g} days"
    print(f"{flown}; after the clients have gone: {left} sessions, {trimmed_mb():.1f} MB")
    if options.json is not None:
        options.json.write_text(json.dumps(samples, indent=1) + "\n", encoding="utf-8")
    wrong = [*wrongs(samples), *(["sessions"] if left else []), *(["clients"] if gone else [])]
    wrong += [f"the served simulator: {error}"] if error else []
    return verdict(wrong)


if __name__ == "__main__":
    sys.exit(main())
