"""The wall-clock cost of a recording: scans at 50 Hz and pictures (JPEG) at 10 Hz, with and without it.

The simulator runs in real time on the lake with one true ping of 513 beams and one true picture, so that the recording
is measured and not the sonar. Cases alternate; each line is the median of the rounds. CPU time is that of the whole
process; lateness is the worst delay of a step, which a recording must not change. Two more cases measure the time of
the simulator's thread per message, and all channels except pictures as fast as possible, where the steps wait for the
file.
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
from _harness import alternated, console, medians, new_table, spent_s
from rich.table import Table as ShownTable

from uwsim import recording
from uwsim.channels import Channel, Table, channels
from uwsim.live import LiveSimulator
from uwsim.recording import Recorder
from uwsim.recording.watch import Watch
from uwsim.simulator.simulator import Simulator

SCAN, PICTURE = "sensor_msgs/msg/LaserScan", "sensor_msgs/msg/CompressedImage"
SWITCH_S = 0.0005  # as uwsim serve sets it
GOALS = {"cpu_share": 0.05, "lateness_ratio": 1.5}


def main(
    seconds: Annotated[float, typer.Option(min=0.5, help="Length of each measurement [s].")] = 4.0,
    rounds: Annotated[int, typer.Option(min=1, help="Measurements of each case.")] = 3,
) -> dict[str, Any]:
    """Measure both cases alternately and print the results."""
    sys.setswitchinterval(SWITCH_S)
    sim = Simulator("lake")
    load = true_channels(sim)
    with tempfile.TemporaryDirectory() as folder:
        numbers = itertools.count()
        cases = {
            "without": lambda: real_time(sim, load, None, seconds),
            "with": lambda: real_time(sim, load, Path(folder) / f"{next(numbers)}.mcap", seconds),
        }
        found = alternated(cases, rounds)
        results: dict[str, Any] = {
            name: medians({key: [each[key] for each in values] for key in values[0]}) for name, values in found.items()
        }
        results["message_us"] = message_cost_us(sim, load, Path(folder))
        results["flat_out"] = flat_out(Path(folder))
    console.print(table(results))
    console.print(
        f"the simulator's thread: {results['message_us']['scan']:.0f} us for a scan, "
        f"{results['message_us']['picture']:.0f} us for a picture; "
        f"flat out, every channel without pictures: {results['flat_out']['with']:.2f} s of wall time for 10 s, "
        f"{results['flat_out']['read']:.2f} s to read the channels alone"
    )
    return results


def true_channels(sim: Simulator) -> list[Channel]:
    """Return two channels that repeat one true scan and one true picture."""
    known = {channel.name: channel for channel in channels(sim)}
    camera = known["camera/front/image_raw/compressed"]
    scan, picture = known["scan"].read(sim), None
    while picture is None:
        picture = camera.read(sim)
        sim.advance(0.1)
    return [
        Channel("scan", SCAN, "out", "", rate_hz=50.0, read=lambda sim: scan),
        Channel("picture", PICTURE, "out", "", rate_hz=10.0, read=lambda sim: picture),
    ]


def sharing(sim: Simulator, load: list[Channel]) -> Table:
    """Return a channel table with only these channels."""
    table = Table(sim)
    table.channels = load
    return table


def real_time(sim: Simulator, load: list[Channel], path: Path | None, seconds: float) -> dict[str, float]:
    """Run in real time; return the share of a core, the lateness and the number of lost messages."""
    with LiveSimulator(sim, speed=1.0) as live:
        if path is None:
            watch = Watch(sim, load, lambda channel, message: None)
            live.read(lambda sim: watch.start()).result()
        else:
            recorder = Recorder(live, path, shared=sharing(sim, load), topics=["scan", "picture"]).start()
        live.clock.wait(0.5)
        live.forget_delays()
        cpu_s, wall_s = time.process_time(), time.perf_counter()
        live.clock.wait(seconds)
        cpu_s, wall_s = time.process_time() - cpu_s, time.perf_counter() - wall_s
        found = {"cpu_share": cpu_s / wall_s, "lateness_ms": 1e3 * live.lateness, "factor": live.factor}
        if path is None:
            live.read(lambda sim: watch.stop()).result()
            return {**found, "dropped": 0.0, "mb_per_s": 0.0}
        recorder.close()
        return {
            **found,
            "dropped": float(recorder.dropped.total()),
            "mb_per_s": 1e-6 * path.stat().st_size / (seconds + 0.5),
        }


def message_cost_us(sim: Simulator, load: list[Channel], folder: Path) -> dict[str, float]:
    """Return the time that the simulator's thread needs to pass on one message [us]."""
    costs = {}
    with Recorder(sim, folder / "cost.mcap", shared=sharing(sim, load), topics=["scan", "picture"]) as recorder:
        for channel in load:
            write = partial(recorder.write, channel, channel.read(sim))
            costs[channel.name] = 1e6 * statistics.median(spent_s(write, time.perf_counter) for _ in range(300))
    return costs


def flat_out(folder: Path) -> dict[str, float]:
    """Return the wall time per ten simulated seconds [s], with a recording and with the channels only read."""
    found = {}
    for name in ("read", "with"):
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
        found[name] = time.perf_counter() - began_s
    assert recording.open(folder / "flat.mcap").complete
    return found


def table(results: dict[str, Any]) -> ShownTable:
    """Return the table of both cases."""
    title = f"in real time: scans at 50 Hz, pictures at 10 Hz (goal: {100 * GOALS['cpu_share']:.0f} % of a core more)"
    shown = new_table(title, "recording", "cores", "latest step [ms]", "pace", "lost", "MB/s")
    for name in ("without", "with"):
        case = results[name]
        shown.add_row(
            name, f"{case['cpu_share']:.3f}", f"{case['lateness_ms']:.2f}", f"{case['factor']:.3f}",
            f"{case['dropped']:.0f}", f"{case['mb_per_s']:.2f}",
        )  # fmt: skip
    return shown
