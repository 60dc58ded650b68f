"""Eight threads that make random calls for ten minutes, on shared objects and on their own.

    .venv/bin/python tools/soak/threads.py [--minutes 10] [--threads 8] [--seed 0]

The rules: only documented errors and no crash; no lost step (of a simulator, a batch, a live simulator); a thread's
work on its own objects gives the same bytes as without other threads; a straight line through samples of memory grows
by at most 2 % after the first fifth of the time, in which memory settles. Exits with 1 if a rule is broken.
"""

from __future__ import annotations

import copy
import faulthandler
import hashlib
import pickle
import random
import sys
import tempfile
import threading
import time
import traceback
from collections import Counter
from collections.abc import Callable
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from steady import growth, trimmed_mb, verdict

from uwsim import Batch, Simulator, recording
from uwsim.live import LiveSimulator
from uwsim.mapping import OccupancyMap
from uwsim.recording import Recorder

MEMBERS, POINTS, PROGRAMS, CALLS_OF_A_PROGRAM = 4, 200, 4, 20
MEMORY, SETTLING, SAMPLE_S = 0.02, 0.2, 20.0
Call = Callable[[random.Random], object]


class Shared:
    """The objects that all threads call."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.sim, self.restored = Simulator("pool", threads=2), Simulator("pool", threads=2)
        self.sim.rov.undock()
        self.state = self.restored.save_state()
        self.map, self.batch = OccupancyMap(0.1), Batch("pool", n=MEMBERS, threads=2)
        self.batch.release()
        self.live = LiveSimulator("pool", paused=True).start()
        self.live.command("undock", vehicle="rov").result()

    def calls(self, stepped: Counter[str]) -> dict[str, Call]:
        """Return all possible calls by name. stepped: the count of one thread."""
        sim, rov, batch, live = self.sim, self.sim.rov, self.batch, self.live

        def counted(name: str, most: int, step: Callable[[random.Random, int], object]) -> Call:
            def call(rng: random.Random) -> None:
                count = rng.randrange(most)
                step(rng, count)
                stepped[name] += count

            return call

        def step_batch(rng: random.Random, count: int) -> None:
            batch.step(count, np.full((MEMBERS, 6), rng.uniform(-1.0, 1.0)))

        def merge(rng: random.Random) -> None:
            other = OccupancyMap(0.1)
            other.insert_scan(scan(rng), np.zeros(3))
            self.map.merge(other)

        return {
            "step": counted("simulator", 50, lambda rng, count: sim.step(count)),
            "batch.step": counted("batch", 20, step_batch),
            "live.step": counted("live", 20, lambda rng, count: live.step(count)),
            "set_effort": lambda rng: rov.set_effort(surge=rng.uniform(-1.0, 1.0), yaw=rng.uniform(-1.0, 1.0)),
            "live.command": lambda rng: live.command("set_effort", vehicle="rov", yaw=rng.uniform(-1.0, 1.0)).result(),
            "live.read": lambda rng: live.read(lambda own: own.rov.pose).result(),
            "live.log": lambda rng: len(live.log),
            "ping": lambda rng: rov.sonar.ping().points_sonar_m,
            "picture": lambda rng: rng.choice(list(rov.cameras.values())).capture().rgb,
            "reading": lambda rng: rng.choice(list(rov.sensors.values())).read(),
            "telemetry": lambda rng: (rov.telemetry(), rov.pose, rov.velocity, rov.collisions),
            "estimate": lambda rng: rov.estimate.pose,
            "batch.observe": lambda rng: batch.observe().position_world_m.sum(),
            "batch.read": lambda rng: batch.read("imu"),
            "batch.ping": lambda rng: batch.ping(),
            "batch.simulator": lambda rng: batch.simulator(rng.randrange(MEMBERS)).rov.pose,
            "save": lambda rng: sim.save_state(),
            "restore": lambda rng: self.restored.restore_state(self.state),
            "run and reset": lambda rng: (self.restored.step(rng.randrange(50)), self.restored.reset()),
            "parameter": lambda rng: self.restored.parameters.update({"rov.mass_kg": rng.uniform(110.0, 130.0)}),
            "place": lambda rng: self.restored.rov.place((rng.uniform(-3.0, 0.0), rng.uniform(-3.0, 3.0), -2.0)),
            "scan": lambda rng: self.map.insert_scan(scan(rng), np.zeros(3)),
            "map.bytes": lambda rng: self.map.to_bytes(rng.choice(["bt", "ot"])),
            "map.query": lambda rng: (self.map.state_at(scan(rng)), self.map.statistics()),
            "map.rays": lambda rng: self.map.cast_rays(np.zeros((POINTS, 3)), scan(rng)),
            "map.leaves": lambda rng: self.map.leaves().centres_m.sum(),
            "map.merge": merge,
            "repr": lambda rng: (repr(sim), repr(rov), repr(batch), repr(self.map), repr(live)),
            "copy": lambda rng: refuses(rng.choice([copy.copy, copy.deepcopy, pickle.dumps]), sim),
            "world": lambda rng: sim.world,
            "recording": self.record,
        }

    def record(self, rng: random.Random) -> None:
        """Record a run, and read the recording."""
        path = self.folder / f"{threading.get_ident()}-{rng.random()}.mcap"
        own = Simulator("pool", seed=rng.randrange(5))
        with Recorder(own, path, topics=["odom", "imu", "scan"]):
            own.rov.undock()
            own.advance(1.0)
        count = sum(1 for _ in recording.open(path).messages("odom"))
        path.unlink()
        if count != 51:  # 50 per second, plus the first
            raise AssertionError(f"{count} messages of odom are in a recording of one second")


def scan(rng: random.Random) -> np.ndarray:
    """Return the points of one of a few scans, so that a map of them does not grow indefinitely."""
    return np.random.default_rng(rng.randrange(50)).uniform(-5.0, 5.0, (POINTS, 3)).astype(np.float32)


def refuses(copied: Callable[[Any], object], sim: Simulator) -> None:
    """Try to copy an object that cannot be copied."""
    with suppress(TypeError):
        copied(sim)
        raise AssertionError(f"{copied} does not refuse a simulator")


def program(number: int) -> str:
    """Run the program with this number on new objects; return the digest of all its outputs."""
    rng, said = random.Random(number), hashlib.sha256()
    sim, occupancy, batch = Simulator("pool", seed=number), OccupancyMap(0.1), Batch("pool", n=2, threads=1)
    sim.rov.undock()
    batch.release()
    for _ in range(CALLS_OF_A_PROGRAM):
        sim.rov.set_effort(surge=rng.uniform(-1.0, 1.0), yaw=rng.uniform(-1.0, 1.0))
        sim.step(rng.randrange(50))
        batch.step(rng.randrange(10), np.full((2, 6), rng.uniform(-1.0, 1.0)))
        occupancy.insert_scan(scan(rng), np.zeros(3))
        said.update(sim.rov.sonar.ping().ranges_m.tobytes() + repr(sim.rov.sensors["depth"].read()).encode())
        if rng.random() < 0.2:
            state = sim.save_state()
            sim.step(7)
            sim.restore_state(state)
    said.update(sim.save_state() + occupancy.to_bytes("ot") + batch.observe().position_world_m.tobytes())
    said.update(sim.rov.cameras["front"].capture().rgb.tobytes())
    return said.hexdigest()


class Worker(threading.Thread):
    """A thread that makes random calls until it is stopped."""

    def __init__(self, shared: Shared, alone: list[str], seed: int, gate: threading.Event) -> None:
        super().__init__()
        self.stepped: Counter[str] = Counter()
        self.called: Counter[str] = Counter()
        self.errors: list[str] = []
        self.busy, self.ends = threading.Lock(), False
        self._alone, self._gate, self._rng = alone, gate, random.Random(seed)
        self._calls = shared.calls(self.stepped) | {"own": self._own}

    def run(self) -> None:
        """Make random calls."""
        names = list(self._calls)
        while not self.ends:
            name = self._rng.choice(names)
            self._gate.wait()
            with self.busy:
                try:
                    self._calls[name](self._rng)
                except Exception:
                    self.errors.append(f"{name}: {traceback.format_exc()}")
            self.called[name] += 1

    def _own(self, rng: random.Random) -> None:
        number = rng.randrange(len(self._alone))
        if program(number) != self._alone[number]:
            raise AssertionError(f"program {number} gives other bytes than alone")


def main(
    minutes: Annotated[float, typer.Option(min=0.05, help="How long the threads call [min].")] = 10.0,
    threads: Annotated[int, typer.Option(min=1, help="Number of threads.")] = 8,
    seed: Annotated[int, typer.Option(help="The seed of the calls.")] = 0,
) -> None:
    """Call, count and compare."""
    faulthandler.enable()
    sys.setswitchinterval(0.0001)  # more often than the default, to provoke more errors
    alone = [program(number) for number in range(PROGRAMS)]
    gate, memory_mb = threading.Event(), []
    with tempfile.TemporaryDirectory() as folder:
        shared = Shared(Path(folder))
        workers = [Worker(shared, alone, seed + number, gate) for number in range(threads)]
        for worker in workers:
            worker.start()
        gate.set()
        ends_s = time.monotonic() + 60.0 * minutes
        while time.monotonic() < ends_s:
            time.sleep(min(SAMPLE_S, 6.0 * minutes))
            gate.clear()
            with ExitStack() as held:  # while no thread is inside a call, so that objects of calls are not counted
                for worker in workers:
                    held.enter_context(worker.busy)
                memory_mb.append(trimmed_mb())
                typer.echo(f"{memory_mb[-1]:.1f} MB")
            gate.set()
        for worker in workers:
            worker.ends = True
        for worker in workers:
            worker.join()
        ticks = {"simulator": shared.sim.tick, "batch": shared.batch.simulator(0).tick, "live": shared.live.tick}
        shared.live.stop()
        left = [path.name for path in shared.folder.iterdir()]
    called, stepped = sum((w.called for w in workers), Counter()), sum((w.stepped for w in workers), Counter())
    errors = [error for worker in workers for error in worker.errors]
    grown = growth(memory_mb, SETTLING)
    for kind, count in Counter(errors).most_common(10):
        typer.echo(f"{count} times {kind}")
    typer.echo(f"{called.total()} calls: {dict(sorted(called.items()))}")
    typer.echo(f"steps {dict(stepped)}, came to {ticks}; memory {grown:+.2%}, at the end {trimmed_mb():.0f} MB")
    rules = {
        f"{len(errors)} errors": not errors,
        "steps": ticks == {name: stepped[name] for name in ticks},
        "memory": grown <= MEMORY,
        f"files left: {left}": not left,
    }
    raise typer.Exit(verdict(name for name, is_kept in rules.items() if not is_kept))


if __name__ == "__main__":
    typer.run(main)
