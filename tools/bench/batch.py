"""The cost of a step per batch member relative to a single simulator, by batch size and threads; memory per member.

The cases alternate in each round, and medians are reported. Vehicles are in open water; random efforts change every
10 steps. What two threads gain is compared with what this machine gains from two batches of half the size, each on a
thread of its own, which never wait for each other. Members with faults or a failsafe, and pings, are compared with
plain members on one thread by processor time.
"""

from __future__ import annotations

import gc
import statistics
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from _harness import alternated, console, medians, ratio, spent_s
from rich.table import Table

from uwsim import Batch, Scenario, Simulator
from uwsim.batch import BatchController
from uwsim.navigation.control import Controller
from uwsim.scenario import load
from uwsim.scenario.spec.failsafe import Failsafe

HELD_STEPS = 10
START_M = (-60.0, -28.0, -10.0)  # in the middle of the lake's water
PAGE_KB = 4
MANY = 256
FEW = 32  # members with faults or a failsafe
PROGRAMS_S = 5.0
CONTROLLED, PERIODS = 256, 100
NEVER_S = 1e5
WEAK = {"kind": "thruster", "axis": "surge", "health": 0.5}
FAULTS = {
    "a fault to come": [{**WEAK, "at_s": NEVER_S}],
    "a fault every 10 s for 5 s": [{**WEAK, "rate_per_h": 360, "for_s": 5}],
    "a leak": [{"kind": "leak", "kg_per_s": 0.01, "at_s": 0}],
}
FAILSAFES = {
    "a failsafe for silence": Failsafe(silence_s=5),
    "one that watches sensors": Failsafe(silence_s=5, leak_then="hold", sensor_then="hold", battery_percent=5),
}


def main(
    scenario: Annotated[str, typer.Option(help="A scenario in which START_M is in open water.")] = "lake",
    rounds: Annotated[int, typer.Option(min=1, help="How often each case is measured.")] = 7,
    steps: Annotated[int, typer.Option(min=1, help="Steps of all members together in a measurement.")] = 100_000,
) -> dict[str, Any]:
    """Measure all cases alternately and print medians."""
    lone = Simulator(scenario, threads=1)
    lone.rov.place(START_M)
    cases = [(n, threads) for n in (1, 16, MANY) for threads in (1, 2) if n >= threads]
    batches = {case: placed(scenario, *case) for case in cases}
    measures: dict[str, Callable[[], float]] = {"lone": lambda: loop_s(lone, steps)}
    for (n, threads), batch in batches.items():
        measures[f"n={n},threads={threads}"] = lambda batch=batch: batch_s(batch, steps)
    found = alternated(measures, rounds)
    table = Table("case", "steps/s", "of the lone simulator", title=f"{scenario}: steps of all members a second")
    results: dict[str, float] = {}
    for name, each_s in found.items():
        rate, of_lone = statistics.median(1 / s for s in each_s), ratio(found["lone"], each_s)
        results |= {f"{name}_steps_s": rate, f"{name}/lone": of_lone}
        table.add_row(name, f"{rate:,.0f}", f"{of_lone:.2f}")
    results["member_kb"] = member_kb(scenario)
    console.print(table)
    results |= two_threads(batches[MANY, 1], batches[MANY, 2], rounds, steps)
    results |= programs(scenario, rounds) | pings(scenario, rounds) | control(scenario, rounds)
    console.print(f"a member of 256, its sensors read once: {results['member_kb']:.0f} kB of resident memory")
    return results


def placed(scenario: str | Scenario, n: int, threads: int) -> Batch:
    """Return a batch in open water."""
    batch = Batch(scenario, n=n, threads=threads)
    batch.place(START_M)
    return batch


def loop_s(sim: Simulator, steps: int) -> float:
    """Return the seconds per step of a single simulator in a Python loop that reads its motion after new efforts."""
    sim.rov.place(START_M)
    efforts = np.random.default_rng(0).uniform(-0.3, 0.3, (steps // HELD_STEPS, 6))
    begin = time.perf_counter()
    for effort in efforts:
        sim.rov.set_effort(*effort.tolist())
        sim.step(HELD_STEPS)
        assert sim.rov.pose and sim.rov.velocity
    return (time.perf_counter() - begin) / (len(efforts) * HELD_STEPS)


def batch_s(batch: Batch, steps: int) -> float:
    """Return the seconds per step and member of a batch whose motion is read equally often."""
    batch.place(START_M)
    calls = max(steps // HELD_STEPS // batch.n, 1)
    efforts = np.random.default_rng(0).uniform(-0.3, 0.3, (calls, batch.n, 6))
    begin = time.perf_counter()
    for effort in efforts:
        batch.step(HELD_STEPS, effort)
        batch.observe()
    return (time.perf_counter() - begin) / (calls * HELD_STEPS * batch.n)


def two_threads(one: Batch, two: Batch, rounds: int, steps: int) -> dict[str, float]:
    """Return how much faster two threads are than one, and how much faster they could be on this machine, wall time."""
    halves = [placed(one.scenario, MANY // 2, 1) for _ in range(2)]
    gains, limits = [], []
    with ThreadPoolExecutor(2) as pool:
        for _ in range(2 * rounds):
            gains.append(batch_s(one, steps) / batch_s(two, steps))
            alone_s = batch_s(halves[0], steps)
            limits.append(2 * alone_s / max(pool.map(batch_s, halves, (steps, steps))))
    gain, limit = statistics.median(gains), statistics.median(limits)
    share = ratio(gains, limits)
    console.print(f"n = {MANY}: two threads over one {gain:.2f}; two batches of half the size, apart {limit:.2f}")
    console.print(f"share of what this machine gains {share:.2f}")
    return {"two_threads/one": gain, "two_batches/one": limit, "two_threads/two_batches": share}


def programs(scenario: str, rounds: int) -> dict[str, float]:
    """Return the processor time of a step of members with faults or a failsafe, relative to plain members."""
    plain = load(scenario)
    cases = {"plain": Batch(plain, n=FEW, threads=1)}
    cases |= {name: Batch(plain, n=FEW, faults=faults, threads=1) for name, faults in FAULTS.items()}
    cases |= {name: Batch(guarded(plain, failsafe), n=FEW, threads=1) for name, failsafe in FAILSAFES.items()}
    found = alternated({name: partial(cpu_s, batch) for name, batch in cases.items()}, rounds)
    table = Table("aboard", "of a plain member's step", title=f"{scenario}: {FEW} members, one thread, processor time")
    results = {f"{name}/plain": ratio(times_s, found["plain"]) for name, times_s in found.items()}
    for name in cases:
        table.add_row(name, f"{results[f'{name}/plain']:.2f}")
    console.print(table)
    return results


def guarded(scenario: Scenario, failsafe: Failsafe) -> Scenario:
    """Return the scenario with a failsafe on its first vehicle."""
    first, *others = scenario.vehicles
    return scenario.model_copy(update={"vehicles": (first.model_copy(update={"failsafe": failsafe}), *others)})


def cpu_s(batch: Batch) -> float:
    """Return the processor time for some seconds of all members, with new efforts every 10 steps."""
    batch.reset()
    batch.place(START_M)
    efforts = np.random.default_rng(0).uniform(-0.3, 0.3, (batch.n, 6))
    begin = time.process_time()
    for _ in range(round(PROGRAMS_S / batch.scenario.step_s) // HELD_STEPS):
        batch.step(HELD_STEPS, efforts)
        batch.observe()
    return time.process_time() - begin


def pings(scenario: str, rounds: int) -> dict[str, float]:
    """Return the processor time of a member's ping in both modes, relative to a single simulator."""
    results: dict[str, float] = {}
    for mode in ("geometry", "physics"):
        change = {f"{load(scenario).vehicles[0].name}.sonar.mode": mode}
        batch, lone = Batch(scenario, n=FEW, parameters=change, threads=1), Simulator(scenario, threads=1)
        lone.parameters.update(change)
        batch.place(START_M)
        lone.rov.place(START_M)

        def together(batch: Batch = batch) -> float:
            batch.step(1)
            return 1e6 * spent_s(batch.ping) / FEW

        def alone(lone: Simulator = lone) -> float:
            lone.step(1)
            return 1e6 * spent_s(lone.rov.sonar.ping)

        results |= against_lone(f"ping_{mode}", together, alone, rounds)
        console.print(f"a ping in {mode} mode: {results[f'ping_{mode}_us']:.0f} us a member")
    return results


def control(scenario: str, rounds: int) -> dict[str, float]:
    """Return the processor time of a member's control period, in seconds and relative to a single Controller."""
    batch, lone = Batch(scenario, n=CONTROLLED, threads=1), Simulator(scenario, threads=1)
    batch.place(START_M)
    lone.rov.place(START_M)
    together, alone = BatchController(batch), Controller(lone.rov)

    def period_us(controller: BatchController | Controller, members: int) -> float:
        return 1e6 * spent_s(lambda: [controller.hold(START_M, 0.3) for _ in range(PERIODS)]) / (members * PERIODS)

    results = against_lone("control", lambda: period_us(together, CONTROLLED), lambda: period_us(alone, 1), rounds)
    console.print(f"a control period: {results['control_us']:.2f} us a member")
    return results


def against_lone(name: str, together: Callable[[], float], alone: Callable[[], float], rounds: int) -> dict[str, float]:
    """Return a member's time [us], and its ratio to that of a single simulator."""
    found = alternated({"together": together, "alone": alone}, rounds)
    return {f"{name}_us": medians(found)["together"], f"{name}/lone": ratio(found["together"], found["alone"])}


def member_kb(scenario: str, n: int = 256) -> float:
    """Return the resident memory that a batch adds per member, excluding shared memory."""
    shared = Batch(scenario, n=1)
    gc.collect()
    before = resident_kb()
    batch = placed(scenario, n, 1)
    batch.step(HELD_STEPS)
    for sensor in shared.simulator(0).rov.sensors:
        batch.read(sensor)
    return (resident_kb() - before) / n


def resident_kb() -> int:
    """Return the resident memory of this process."""
    return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * PAGE_KB
