"""Eight simulated days of surveys, pings, images and missions in one process, while it serves a few clients.

    .venv/bin/python tools/soak/days.py [--days 8] [--minutes 60] [--json FILE]

A lap is 1.5 simulated hours: 33 minutes of a lake survey, 6 minutes of five pool surveys, 20 s of `uwsim fingerprint`
(images, samples and pings of both modes), 1 minute of a mission that maps, 10 minutes with a ping each second, and idle
flight for the rest; the last two use one simulator that is restored to its initial state. It takes about 22 s of
processor time. Each lap's output must be byte-identical to the first's. At the same time, a rosbridge server with its
own simulator runs on the wall clock for the clients of clients.py, which run in another process.

One line is printed after each lap: simulated days, resident memory (after a garbage collection, before and after the C
library has returned its freed blocks), memory allocated by malloc, the peak, and processor seconds per simulated hour,
excluding those of the server. The exit code is 1 if memory grew by more than 2 % (straight line), processor time
drifted by more than 5 % (medians of the first and last third), bytes differ, or the number of threads or open files
rose. The first fifth of the laps, in which these values settle, is ignored.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from steady import drift, growth, in_use_mb, open_files, peak_mb, resident_mb, thread_cpu_s, trimmed_mb

import uwsim
from uwsim.bridges import RosbridgeServer
from uwsim.cli.run_live import keep_threads_moving
from uwsim.evidence.fingerprint import fingerprint
from uwsim.examples.m01_hello_dive import mission
from uwsim.live import LiveSimulator

DAY_S, HOUR_S = 86_400.0, 3600.0
POOL_SURVEYS, PINGS = 5, 600
MEMORY, PACE, SETTLING = 0.02, 0.05, 0.2
LAPS_MIN = 10  # fewer laps are not conclusive
Digest = Callable[[bytes], None]


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
        digests["mission"] = digest(dive.occupancy.to_bytes("bt"))
        flown_s += dive.simulated_s
        digests["flight"] = self._ping_and_idle(self._lap_s - flown_s)
        return digests

    def _ping_and_idle(self, flight_s: float) -> str:
        sim = self._idle
        sim.restore_state(self._start)
        sim.rov.undock()
        sim.rov.set_effort(surge=0.3, yaw=0.1)
        seen = hashlib.sha256()
        for _ in range(PINGS):
            sim.advance(1.0)
            seen.update(sim.rov.sonar.ping().ranges_m)
        sim.advance(flight_s - PINGS)
        seen.update(np.concatenate([sim.rov.pose.position_world_m, sim.rov.pose.orientation_xyzw]))
        return seen.hexdigest()


def survey(scenario: str, folder: Path, digests: dict[str, str]) -> float:
    """Fly a survey without output; return its simulated time [s]."""
    with (
        Path(os.devnull).open("w") as nowhere,
        contextlib.redirect_stdout(nowhere),
        contextlib.redirect_stderr(nowhere),
    ):
        record = uwsim.run_survey(scenario, folder / scenario, seed=7, threads=1, report="none")
    found = digest((folder / scenario / "map.bt").read_bytes())
    if digests.setdefault(scenario, found) != found:
        digests[scenario] = "differs within one lap"
    return float(record.simulated_s)


def digest(content: bytes) -> str:
    """Return the hash of some bytes."""
    return hashlib.sha256(content).hexdigest()


def lap_cpu_s(work: Callable[[], Any]) -> tuple[float, Any]:
    """Return the processor time of a call, and its result.

    Threads that the call starts, such as a map's, are included; threads that existed before, such as the server's, are
    not.
    """
    before, began_s = thread_cpu_s(), time.process_time()
    result = work()
    used_s, after = time.process_time() - began_s, thread_cpu_s()
    others = (before.keys() & after.keys()) - {os.getpid()}
    return used_s - sum(after[thread] - before[thread] for thread in others), result


def sample(laps: Laps, lap_s: float) -> dict[str, Any]:
    """Fly a lap; return its cost and the memory in use after it."""
    began_s = time.monotonic()
    cpu_s, digests = lap_cpu_s(laps.fly)
    wall_s = time.monotonic() - began_s
    return {
        "simulated_s": lap_s,
        "wall_s": wall_s,
        "resident_mb": resident_mb(),
        "memory_mb": trimmed_mb(),
        "in_use_mb": in_use_mb(),
        "objects": sys.getallocatedblocks(),
        "peak_mb": peak_mb(),
        "cpu_s_per_h": HOUR_S * cpu_s / lap_s,
        "threads": len(thread_cpu_s()),
        "files": open_files(),
        "digests": digests,
    }


def told(sample: dict[str, Any], first: dict[str, Any], days: float) -> str:
    """Return the report line of a lap."""
    other = [part for part, found in sample["digests"].items() if found != first["digests"][part]]
    verdict = f"bytes of {', '.join(other)} DIFFER" if other else "bytes same"
    return (
        f"{days:5.2f} days: {sample['memory_mb']:.1f} MB ({sample['resident_mb']:.1f} before the trim, "
        f"{sample['in_use_mb']:.1f} in use, peak {sample['peak_mb']:.1f}), "
        f"{sample['cpu_s_per_h']:.3f} CPU s/h, "
        f"{sample['wall_s']:.0f} s of wall, {sample['threads']} threads, {sample['files']} files, {verdict}"
    )


def fly_days(days: float, minutes: float, lap_s: float, live: LiveSimulator) -> list[dict[str, Any]]:
    """Fly laps until the days or the minutes have elapsed; print a line for each."""
    ends_s = time.monotonic() + 60.0 * minutes
    samples: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory() as name:
        laps = Laps(Path(name), lap_s)
        while len(samples) < days * DAY_S / lap_s and time.monotonic() < ends_s:
            live.reset()  # the clients' vehicle and map restart
            samples.append(sample(laps, lap_s) | {"served": live.factor, "commands": len(live.log)})
            print(told(samples[-1], samples[0], len(samples) * lap_s / DAY_S), flush=True)
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
    parser.add_argument("--lap-hours", type=float, default=1.5, help="simulated hours per lap, at least 1")
    parser.add_argument("--json", type=Path, help="also write the samples to this file")
    options = parser.parse_args()
    if not options.lap_hours >= 1.0:
        parser.error(f"--lap-hours {options.lap_hours:g}: must be at least 1")
    keep_threads_moving()
    with LiveSimulator(uwsim.Simulator("lake", threads=1)) as live, RosbridgeServer(live) as server:
        seconds = 60.0 * options.minutes + 3600.0
        clients = [sys.executable, str(Path(__file__).with_name("clients.py")), server.url, str(seconds)]
        with subprocess.Popen(clients) as process:
            signal.signal(signal.SIGTERM, signal.default_int_handler)  # the clients end with this process
            try:
                samples = fly_days(options.days, options.minutes, HOUR_S * options.lap_hours, live)
                gone = process.poll() is not None
            finally:
                process.kill()
        time.sleep(5.0)
        left, error = len(server.sessions), live.error
    flown = f"{len(samples) * options.lap_hours / 24:g} days"
    print(f"{flown}; after the clients have gone: {left} sessions, {trimmed_mb():.1f} MB")
    if options.json is not None:
        options.json.write_text(json.dumps(samples, indent=1) + "\n", encoding="utf-8")
    wrong = [*wrongs(samples), *(["sessions"] if left else []), *(["clients"] if gone else [])]
    wrong += [f"the served simulator: {error}"] if error else []
    print(f"wrong: {', '.join(wrong) or 'nothing'}")
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
