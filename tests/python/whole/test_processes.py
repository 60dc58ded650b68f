"""Forks, threads, Ctrl-C and interpreter shutdown, at any time."""

import gc
import os
import signal
import subprocess
import sys
import threading
import time
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

import numpy as np
import pytest

from uwsim import Batch, Simulator, _core
from uwsim.bridges import RosbridgeServer
from uwsim.live import LiveSimulator
from uwsim.mapping import OccupancyMap
from uwsim.recording import Recorder
from uwsim.scenario import build_world, load

ORIGIN_M = np.zeros(3)


def points(count: int) -> np.ndarray:
    return np.random.default_rng(0).uniform(-10.0, 10.0, (count, 3)).astype(np.float32)


@contextmanager
def threads_that_repeat(*calls: Callable[[], object]) -> Iterator[list[BaseException]]:
    """Run each call repeatedly on its own thread; yield the list of exceptions raised."""
    ended, raised = threading.Event(), []

    def repeat(call: Callable[[], object]) -> None:
        try:
            while not ended.is_set():
                call()
        except BaseException as error:
            raised.append(error)

    threads = [threading.Thread(target=repeat, args=(call,)) for call in calls]
    for thread in threads:
        thread.start()
    try:
        yield raised
    finally:
        ended.set()
        for thread in threads:
            thread.join()


def in_a_fork(call: Callable[[], object], limit_s: int = 600) -> str:
    """Return the outcome of a call in a forked child: "done", the error's text, or "hangs" after limit_s."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.alarm(limit_s)
        try:
            call()
            os.write(writer, b"done")
        except BaseException as error:
            os.write(writer, str(error).encode())
        os._exit(0)
    os.close(writer)
    with os.fdopen(reader) as told:
        text = told.read()
    os.waitpid(child, 0)
    return text or "hangs"


def test_a_child_forked_while_threads_work_has_an_error_or_works() -> None:
    occupancy, sim = OccupancyMap(0.1), Simulator("pool", threads=2)
    many, few = points(20_000), points(100)

    def fresh() -> None:
        OccupancyMap(0.1).insert_scan(few, ORIGIN_M)
        Simulator("pool").step(3)

    with threads_that_repeat(lambda: occupancy.insert_scan(many, ORIGIN_M), lambda: sim.step(2000)) as raised:
        time.sleep(0.1)
        told = [
            in_a_fork(call)
            for call in (lambda: occupancy.insert_scan(few, ORIGIN_M), lambda: sim.step(3), fresh)
            for _ in range(2)
        ]
    assert raised == []
    assert all(text == "done" or "begin child processes by multiprocessing's 'spawn'" in text for text in told[:4]), (
        told
    )
    assert told[4:] == ["done", "done"]


def test_a_child_prepares_a_world_for_rays_that_its_parent_has_not() -> None:
    Simulator("pool").scene.prepare()  # Embree's threads exist in the parent only
    scene = _core.RayScene(build_world(load("lake")))

    def hit() -> None:
        assert np.isfinite(scene.cast([[0.0, 0.0, -1.0]], [[0.0, 0.0, -1.0]], 1000.0).ranges_m).all()

    assert in_a_fork(hit) == "done"
    hit()


def test_eight_threads_share_a_simulator_and_a_map() -> None:
    sim, occupancy = Simulator("pool", threads=2), OccupancyMap(0.1)
    sim.rov.undock()
    few, steps = points(200), [0, 0]

    def step(which: int) -> None:
        sim.step(7)
        steps[which] += 7

    calls = (
        lambda: step(0),
        lambda: step(1),
        lambda: sim.rov.sonar.ping().ranges_m.sum(),
        lambda: sim.rov.set_effort(surge=0.3),
        lambda: sim.rov.telemetry(),
        lambda: sim.rov.sensors["depth"].read(),
        lambda: occupancy.insert_scan(few, ORIGIN_M),
        lambda: occupancy.to_bytes("bt"),
    )
    with threads_that_repeat(*calls) as raised:
        time.sleep(0.3)
    assert raised == []
    assert sim.tick == sum(steps) > 0


def test_parts_outlive_their_simulator() -> None:
    sim = Simulator("pool")
    rov, ping, camera = sim.rov, sim.rov.sonar.ping(), next(iter(sim.rov.cameras.values()))
    batch = Batch("pool", n=2)
    member, aboard = batch.simulator(1), batch.aboard(1)
    del sim, batch
    gc.collect()
    assert np.isfinite(rov.pose.position_world_m).all()
    assert ping.ranges_m.size > 0
    assert camera.capture().rgb.size > 0
    assert member.rov.sonar.ping().ranges_m.size > 0
    assert aboard.save_state()


@pytest.mark.parametrize("name", ["recorded", "served", "of a live one", "of a batch"])
def test_what_has_used_a_simulator_lets_it_go(name: str, tmp_path: Path) -> None:
    sim = Simulator("pool")
    if name == "recorded":
        with Recorder(sim, tmp_path / "run.mcap", topics=["odom"]):
            sim.advance(0.1)
    elif name == "of a batch":
        sim = Batch("pool", n=2).simulator(0)
    else:
        with LiveSimulator(sim, speed="max") as live, RosbridgeServer(live) if name == "served" else nullcontext():
            live.clock.wait(0.1)
        del live
    known = weakref.ref(sim)
    del sim
    end_s = time.monotonic() + 600.0
    while known() is not None and time.monotonic() < end_s:  # finishing threads may still hold a reference
        gc.collect()
        time.sleep(0.01)
    assert known() is None


LONG = """
import signal, tempfile, uwsim
import uwsim.flight.fly  # in some imports Python itself changes a KeyboardInterrupt to an error
signal.signal(signal.SIGINT, signal.default_int_handler)  # the process that started this may ignore it
sim, batch, folder = uwsim.Simulator("pool"), uwsim.Batch("pool", n=4), tempfile.mkdtemp()
uwsim.Simulator("lake")
for call in (
    lambda: sim.advance(1e7),
    lambda: batch.step(10**9),
    lambda: uwsim.run_survey("lake", folder, report="none"),
    lambda: [sim.rov.sonar.ping() for _ in range(10**9)],
):
    try:
        print("begun", flush=True)
        call()
    except KeyboardInterrupt:
        sim.step(3); batch.step(3); sim.rov.sonar.ping()
        print("usable", flush=True)
"""


def test_ctrl_c_ends_a_long_call_and_leaves_the_simulator_usable() -> None:
    with subprocess.Popen([sys.executable, "-c", LONG], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        for _ in range(4):
            assert process.stdout.readline() == b"begun\n"
            time.sleep(0.5)
            process.send_signal(signal.SIGINT)
            assert process.stdout.readline() == b"usable\n"
        out, errors = process.communicate(timeout=600)
    assert (process.returncode, out) == (0, b""), errors.decode()


@pytest.mark.parametrize("after_s", [0.0, 0.3])
def test_the_interpreter_ends_while_threads_work(after_s: float) -> None:
    program = f"""
import threading, time
import numpy as np
from uwsim import Simulator
from uwsim.live import LiveSimulator
from uwsim.mapping import OccupancyMap
points = np.random.default_rng(0).uniform(-10, 10, (20000, 3)).astype(np.float32)
sim, occupancy, live = Simulator("pool"), OccupancyMap(0.1), LiveSimulator("pool")
live.start()
def forever(call):
    while True: call()
for call in (lambda: sim.step(2000), lambda: occupancy.insert_scan(points, np.zeros(3)), sim.rov.sonar.ping):
    threading.Thread(target=forever, args=(call,), daemon=True).start()
time.sleep({after_s})
"""
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=600, check=False)
    assert (ended.returncode, ended.stderr) == (0, "")
