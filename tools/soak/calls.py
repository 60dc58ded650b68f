"""Random calls by threads on objects that all share, and programs on objects of their own."""

from __future__ import annotations

import copy
import hashlib
import pickle
import random
import threading
import traceback
from collections import Counter
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from uwsim import Batch, Simulator, fly, recording, run_survey
from uwsim.evidence.fingerprint import fingerprint
from uwsim.examples.m01_hello_dive import mission
from uwsim.live import LiveSimulator
from uwsim.mapping import OccupancyMap
from uwsim.recording import Recorder

MEMBERS, POINTS, PROGRAMS, CALLS_OF_A_PROGRAM = 4, 200, 4, 20
PINGS, IDLE_S = 60, 1800.0
Call = Callable[[random.Random], object]


class Shared:
    """The objects that all threads call."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.left = folder / "recordings", list[str]()
        self.folder.mkdir()
        self.sim, self.restored = Simulator("pool", threads=2), Simulator("pool", threads=2)
        self.sim.rov.undock()
        self.state = self.restored.save_state()
        self.map, self.batch = OccupancyMap(0.1), Batch("pool", n=MEMBERS, threads=2)
        self.batch.release()
        self.live = LiveSimulator("pool", paused=True).start()
        self.live.command("undock", vehicle="rov").result()

    def stopped(self) -> dict[str, int]:
        """Stop; return the ticks of the objects that were stepped."""
        self.live.stop()
        self.left = [path.name for path in self.folder.iterdir()]
        return {"simulator": self.sim.tick, "batch": self.batch.simulator(0).tick, "live": self.live.tick}

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


def programs(folder: Path) -> dict[str, Callable[[], str]]:
    """Return what a thread does on its own objects, by name: each gives the digest of all its outputs."""

    def survey() -> str:
        path = folder / f"survey-{threading.get_ident()}"
        run_survey("pool", path, seed=7, threads=1, report="none")
        return hashlib.sha256((path / "map.bt").read_bytes()).hexdigest()

    def dive() -> str:
        occupancy = fly(mission, "lake", map=True, seed=7, threads=1).occupancy
        assert occupancy is not None
        return hashlib.sha256(occupancy.to_bytes("bt")).hexdigest()

    own = {"survey": survey, "dive": dive, "flight": idle_flight}
    own["fingerprint"] = lambda: fingerprint("pool", seed=7, threads=1).whole
    return own | {f"program {number}": partial(program, number) for number in range(PROGRAMS)}


def idle_flight() -> str:
    """Fly half an hour, of which a minute with pings; return the digest of pings and pose."""
    sim, seen = Simulator("lake", seed=7, threads=1), hashlib.sha256()
    sim.rov.undock()
    sim.rov.set_effort(surge=0.3, yaw=0.1)
    for _ in range(PINGS):
        sim.advance(1.0)
        seen.update(sim.rov.sonar.ping().ranges_m)
    sim.advance(IDLE_S)
    seen.update(np.concatenate([sim.rov.pose.position_world_m, sim.rov.pose.orientation_xyzw]))
    return seen.hexdigest()


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

    def __init__(
        self,
        shared: Shared,
        own: Mapping[str, Callable[[], str]],
        alone: Mapping[str, str],
        seed: int,
        gate: threading.Event,
    ) -> None:
        super().__init__()
        self.stepped: Counter[str] = Counter()
        self.called: Counter[str] = Counter()
        self.errors: list[str] = []
        self.busy, self.ends = threading.Lock(), False
        self._own, self._alone, self._gate, self._rng = own, alone, gate, random.Random(seed)
        self._calls = shared.calls(self.stepped) | {"own": self._on_its_own}

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

    def _on_its_own(self, rng: random.Random) -> None:
        name = rng.choice(list(self._own))
        if self._own[name]() != self._alone[name]:
            raise AssertionError(f"{name} gives other bytes than alone")
