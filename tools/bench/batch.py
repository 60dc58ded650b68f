"""The cost of a member of a batch: steps, pings and control beside a single simulator's; two threads; memory.

Vehicles are in open water; random efforts change every 10 steps. What two threads gain is compared with two batches of
half the size, each on a thread of its own, which never wait for each other.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Annotated, Any

import numpy as np
import typer
from _harness import Rounds, beside, ratio, resident_mb, show, spent_s

from uwsim import Batch, Scenario, Simulator
from uwsim.batch import BatchController
from uwsim.navigation.control import Controller
from uwsim.scenario import load
from uwsim.scenario.spec.failsafe import Failsafe

HELD_STEPS = 10
START_M = (-60.0, -28.0, -10.0)  # in the middle of the lake's water
MANY, FEW = 256, 32  # FEW: members with faults or a failsafe
PROGRAMS_S, PERIODS = 5.0, 100
WEAK = {"kind": "thruster", "axis": "surge", "health": 0.5}
FAULTS: dict[str, Any] = {
    "a fault to come": [{**WEAK, "at_s": 1e5}],
    "a fault every 10 s for 5 s": [{**WEAK, "rate_per_h": 360, "for_s": 5}],
    "a leak": [{"kind": "leak", "kg_per_s": 0.01, "at_s": 0}],
}
FAILSAFES = {
    "a failsafe for silence": Failsafe(silence_s=5),
    "one that watches sensors": Failsafe(silence_s=5, leak_then="hold", sensor_then="hold", battery_percent=5),
}


def main(
    scenario: Annotated[str, typer.Option(help="A scenario in which START_M is in open water.")] = "lake",
    rounds: Rounds = 7,
    steps: Annotated[int, typer.Option(min=1, help="Steps of all members together in a measurement.")] = 100_000,
) -> dict[str, Any]:
    """Measure all cases alternately and print medians."""
    lone = Simulator(scenario, threads=1)
    batches = {(n, threads): Batch(scenario, n=n, threads=threads) for n in (1, 16, MANY) for threads in (1, 2)[:n]}
    cases: dict[str, Callable[[], float]] = {"single simulator": partial(loop_s, lone, steps)}
    cases |= {f"n={n}, threads={threads}": partial(batch_s, each, steps) for (n, threads), each in batches.items()}
    results: dict[str, Any] = {"step": beside("a step of a member, wall time", cases, rounds, "single simulator")}
    results["gains"] = two_threads(batches[MANY, 1], batches[MANY, 2], rounds, steps)
    results["gains"]["kB of a member whose sensors are read"] = member_kb(scenario)
    show(f"{MANY} members", results["gains"])
    plain = load(scenario)
    aboard = {"plain": Batch(plain, n=FEW, threads=1)}
    aboard |= {name: Batch(plain, n=FEW, faults=faults, threads=1) for name, faults in FAULTS.items()}
    first, *others = plain.vehicles
    for name, failsafe in FAILSAFES.items():
        guarded = plain.model_copy(update={"vehicles": (first.model_copy(update={"failsafe": failsafe}), *others)})
        aboard[name] = Batch(guarded, n=FEW, threads=1)
    programs = {name: partial(programs_s, batch) for name, batch in aboard.items()}
    results["aboard"] = beside(f"{PROGRAMS_S:g} s of {FEW} members, processor time", programs, rounds, "plain")
    for mode in ("geometry", "physics"):
        results[f"ping, {mode}"] = beside(f"a ping, {mode}, processor time", pings(plain, mode), rounds, "alone")
    results["control"] = beside("a control period, processor time", control(plain), rounds, "alone")
    return results


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
    halves = [Batch(one.scenario, n=MANY // 2, threads=1) for _ in range(2)]
    gains, limits = [], []
    with ThreadPoolExecutor(2) as pool:
        for _ in range(2 * rounds):
            gains.append(batch_s(one, steps) / batch_s(two, steps))
            alone_s = batch_s(halves[0], steps)
            limits.append(2 * alone_s / max(pool.map(batch_s, halves, (steps, steps))))
    gain, limit = statistics.median(gains), statistics.median(limits)
    return {"two threads/one": gain, "two batches/one": limit, "two threads/two batches": ratio(gains, limits)}


def programs_s(batch: Batch) -> float:
    """Return the processor time for some seconds of all members, with new efforts every 10 steps."""
    batch.reset()
    batch.place(START_M)
    efforts = np.random.default_rng(0).uniform(-0.3, 0.3, (batch.n, 6))

    def run() -> None:
        for _ in range(round(PROGRAMS_S / batch.scenario.step_s) // HELD_STEPS):
            batch.step(HELD_STEPS, efforts)
            batch.observe()

    return spent_s(run)


def pings(scenario: Scenario, mode: str) -> dict[str, Callable[[], float]]:
    """Return measurements of a ping of a member, and of a single simulator."""
    change = {f"{scenario.vehicles[0].name}.sonar.mode": mode}
    batch, lone = Batch(scenario, n=FEW, parameters=change, threads=1), Simulator(scenario, threads=1)
    lone.parameters.update(change)
    batch.place(START_M)
    lone.rov.place(START_M)

    def ping_s(stepped: Batch | Simulator, ping: Callable[[], object], members: int) -> float:
        stepped.step(1)
        return spent_s(ping) / members

    return {"alone": partial(ping_s, lone, lone.rov.sonar.ping, 1), "member": partial(ping_s, batch, batch.ping, FEW)}


def control(scenario: Scenario) -> dict[str, Callable[[], float]]:
    """Return measurements of a control period of a member, and of a single simulator."""

    def measured(of: Any, controller: BatchController | Controller, members: int) -> Callable[[], float]:
        of.place(START_M)
        hold = lambda: [controller.hold(START_M, 0.3) for _ in range(PERIODS)]  # noqa: E731
        return lambda: spent_s(hold) / (members * PERIODS)

    batch, rov = Batch(scenario, n=MANY, threads=1), Simulator(scenario, threads=1).rov
    return {"alone": measured(rov, Controller(rov), 1), "member": measured(batch, BatchController(batch), MANY)}


def member_kb(scenario: str) -> float:
    """Return the resident memory that a batch adds per member, excluding shared memory."""
    shared = Batch(scenario, n=1)
    before_mb = resident_mb()
    batch = Batch(scenario, n=MANY, threads=1)
    batch.place(START_M)
    batch.step(HELD_STEPS)
    for sensor in shared.simulator(0).rov.sensors:
        batch.read(sensor)
    return 1e3 * (resident_mb() - before_mb) / MANY
