"""The wall-clock cost of a recording: scans at 50 Hz and pictures (JPEG) at 10 Hz, with and without it.

The simulator runs in real time on the lake with one true ping of 513 beams and one true picture. Also the time of its
thread per message, of all channels except pictures as fast as possible, where the steps wait for the file, and of the
pool's survey with and without `--record`.
"""

from __future__ import annotations

import itertools
import statistics
import sys
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer
from _harness import PICTURE, SCAN, SWITCH_S, alternated, cores_used, medians, show, spent_s, true_messages

from uwsim import recording
from uwsim.channels import Channel, Table
from uwsim.flight.record import FlightRecord
from uwsim.flight.stages import RECORDING
from uwsim.flight.survey import run_survey
from uwsim.flight.terminal import Silent
from uwsim.live import LiveSimulator
from uwsim.recording import Recorder
from uwsim.recording.watch import Watch
from uwsim.simulator.simulator import Simulator

TOPICS = ["scan", "picture"]


def main(
    seconds: Annotated[float, typer.Option(min=0.5, help="Length of each measurement [s].")] = 4.0,
    rounds: Annotated[int, typer.Option(min=1, help="Measurements of each case.")] = 3,
) -> dict[str, Any]:
    """Measure both cases alternately and print the results."""
    sys.setswitchinterval(SWITCH_S)
    sim = Simulator("lake")
    scan, picture = true_messages(sim)
    shared = Table(sim)
    shared.channels = [
        Channel("scan", SCAN, "out", "", rate_hz=50.0, read=lambda sim: scan),
        Channel("picture", PICTURE, "out", "", rate_hz=10.0, read=lambda sim: picture),
    ]
    with tempfile.TemporaryDirectory() as name:
        folder, numbers = Path(name), itertools.count()
        cases = {
            "without": lambda: real_time(sim, shared, None, seconds),
            "with": lambda: real_time(sim, shared, folder / f"{next(numbers)}.mcap", seconds),
        }
        results: dict[str, float] = {}
        for case, rows in alternated(cases, rounds).items():
            middle = medians({key: [row[key] for row in rows] for key in rows[0]})
            results |= {f"{case}: {key}": value for key, value in middle.items()}
        results["more cores"] = results["with: cores"] - results["without: cores"]
        results |= message_cost_us(sim, shared, folder) | flat_out(folder)
        results |= medians(survey_s(folder, rounds))
    show("scans at 50 Hz and pictures at 10 Hz in real time, and flat out", results, {"more cores": "<= 0.05"})
    return results


def real_time(sim: Simulator, shared: Table, path: Path | None, seconds: float) -> dict[str, float]:
    """Run in real time; return the share of a core, the lateness, the pace and the number of lost messages."""
    with LiveSimulator(sim, speed=1.0) as live:
        watch = Watch(sim, shared.channels, lambda channel, message: None)
        recorder = Recorder(live, path, shared=shared, topics=TOPICS) if path else None
        if recorder:
            recorder.start()
        else:
            live.read(lambda sim: watch.start()).result()
        live.clock.wait(0.5)
        live.forget_delays()
        cores, _ = cores_used(lambda: live.clock.wait(seconds))
        found = {"cores": cores, "latest step [ms]": 1e3 * live.lateness, "pace": live.factor, "lost": 0.0}
        if recorder and path:
            recorder.close()
            found["lost"] = float(recorder.dropped.total())
            found["MB/s"] = 1e-6 * path.stat().st_size / (seconds + 0.5)
        else:
            live.read(lambda sim: watch.stop()).result()
        return found


def message_cost_us(sim: Simulator, shared: Table, folder: Path) -> dict[str, float]:
    """Return the time that the simulator's thread needs to pass on one message [us]."""
    costs = {}
    with Recorder(sim, folder / "cost.mcap", shared=shared, topics=TOPICS) as recorder:
        for channel in shared.channels:
            write = partial(recorder.write, channel, channel.read(sim))
            costs[f"a {channel.name} on the simulator's thread [us]"] = 1e6 * statistics.median(
                spent_s(write, time.perf_counter) for _ in range(300)
            )
    return costs


def survey_s(folder: Path, rounds: int) -> dict[str, list[float]]:
    """Return the wall times of the pool's survey [s], alternately with and without a recording, and their ratios."""

    def flown(name: str, **options: Any) -> FlightRecord:
        return run_survey("pool", folder / f"{name}{next(numbers)}", report="json", screen=Silent(), **options)

    numbers = itertools.count()
    cases = {
        "alone": lambda: flown("alone"),
        "recorded": lambda: flown("recorded", record=folder / f"survey{next(numbers)}.mcap"),
    }
    records = alternated(cases, rounds)
    alone, recorded = ([one.wall_s for one in records[case]] for case in cases)
    return {
        "survey of the pool [s]": alone,
        "survey of the pool, recorded [s]": recorded,
        "of which the stage 'recording' [s]": [one.stage_wall_s[RECORDING] for one in records["recorded"]],
        "survey of the pool, recorded / alone": [b / a for a, b in zip(alone, recorded, strict=True)],
    }


def flat_out(folder: Path) -> dict[str, float]:
    """Return the wall time per ten simulated seconds [s], with a recording and with the channels only read."""
    found = {}
    for name in ("read", "recorded"):
        sim = Simulator("lake")
        sim.rov.undock()
        shared = Table(sim)
        shared.channels = chosen = [c for c in shared.channels if c.direction == "out" and not c.delivery.late]
        began_s = time.perf_counter()
        if name == "read":
            watch = Watch(sim, chosen, lambda channel, message: None)
            watch.start()
            sim.advance(10.0)
            watch.stop()
        else:
            with Recorder(sim, folder / "flat.mcap", shared=shared):
                sim.advance(10.0)
        found[f"10 s flat out without pictures, {name} [s]"] = time.perf_counter() - began_s
    assert recording.open(folder / "flat.mcap").complete
    return found
