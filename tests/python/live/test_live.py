"""A live simulator steps like a simulator, responds while paused, and survives every error."""

import gc
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import Future
from types import SimpleNamespace
from typing import Any
from weakref import ref

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.live import Entry, LiveSimulator, NotRunningError, replay
from uwsim.navigation.control import Autopilot, Clock, SteeredVehicle
from waiting import until

PATIENCE_S = 180.0  # time limit for events that are immediate on an idle machine


@pytest.fixture
def live() -> Iterator[LiveSimulator]:
    with LiveSimulator("pool", speed="max", paused=True) as simulator:
        yield simulator


def result(future: Future[Any]) -> Any:
    return future.result(timeout=PATIENCE_S)


def test_commands_between_steps_give_the_same_bytes_as_on_a_simulator(live: LiveSimulator) -> None:
    sim = Simulator("pool")
    for each in (live, sim):
        each.rov.release()
        each.rov.set_effort(surge=0.5, yaw=-0.1)
        each.step(300)
        each.rov.sonar.aim(-0.4)
        each.step(200)
    assert live.simulator.save_state() == sim.save_state()


def test_a_stopped_one_is_freed_although_its_simulators_observers_hold_it() -> None:
    with LiveSimulator("pool", paused=True) as live:
        live.simulator.journal.attach(SimpleNamespace(live=live))  # as the judge of an exercise does
    gone = ref(live)
    del live
    gc.collect()
    assert gone() is None


def test_what_several_threads_command_replays_to_the_same_bytes(live: LiveSimulator) -> None:
    live.resume()

    def drive(axis: str) -> None:
        for k in range(40):
            live.command("set_effort", vehicle="rov", **{axis: 0.02 * k}).result()

    live.rov.release()
    threads = [threading.Thread(target=drive, args=[axis]) for axis in ("surge", "sway", "yaw")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    live.call(lambda sim: sim.rov.set_effort(heave=-0.3)).result()
    live.rov.lamps["front"].on = True
    live.pause()
    assert len(live.log) == 3 * 40 + 3
    again = replay("pool", live.log, live.simulator.tick)
    assert again.save_state() == live.simulator.save_state()


def test_a_command_takes_effect_before_steps_that_are_asked_for_later(live: LiveSimulator) -> None:
    live.every(0.005, lambda sim: None, lambda _: time.sleep(0.002))  # commands arrive while it is busy
    for k in range(50):
        live.command("set_effort", vehicle="rov", surge=0.01 * k)
        live.step(1)
    with live.mission_clock() as clock:
        live.command("set_effort", vehicle="rov", surge=0.5)
        live.resume()
        live.command("set_effort", vehicle="rov", surge=0.6)
        clock.wait(0.005)
    assert [entry.tick for entry in live.log] == [*range(50), 50, 50]


def test_a_reset_is_replayed_too_and_entries_out_of_order_are_not(live: LiveSimulator) -> None:
    live.command("set_effort", vehicle="rov", surge=0.5)
    live.rov.release()
    live.step(50)
    middle = result(live.read(lambda sim: sim.save_state()))
    live.step(50)
    live.reset(middle)
    assert live.simulator.tick == 50
    live.step(10)
    live.reset()
    assert live.simulator.tick == 0
    live.step(7)
    assert replay("pool", live.log, 7).save_state() == live.simulator.save_state()
    entries = [Entry(tick, "release", {"vehicle": "rov"}) for tick in (5, 3)]
    with pytest.raises(ValueError, match="tick 3 is before tick 5"):
        replay("pool", entries, 10)


def test_readings_come_at_multiples_of_their_period_in_simulated_time_until_cancelled(live: LiveSimulator) -> None:
    ticks: list[int] = []
    subscription = live.every(0.012, lambda sim: sim.tick, ticks.append)  # each 2.4 steps: at the next step each time
    until(lambda: ticks == [0])
    live.step(13)
    result(live.read(lambda sim: None))
    until(lambda: ticks == [0, 3, 5, 8, 10, 12])
    live.reset()
    until(lambda: ticks == [0, 3, 5, 8, 10, 12, 0])
    subscription.cancel()
    live.step(20)
    assert max(ticks) <= 12


def test_a_sink_may_command_and_an_error_in_it_ends_neither_the_thread_nor_the_subscription(
    live: LiveSimulator,
) -> None:
    def fail(tick: int) -> None:
        raise ZeroDivisionError(f"at {tick}")

    subscription = live.every(0.005, lambda sim: sim.tick, fail)
    live.every(0.05, lambda sim: sim.time_s, lambda time_s: live.rov.set_effort(surge=0.1 * time_s))
    live.step(20)
    until(lambda: subscription.errors == 21 and len(live.log) == 3)
    assert isinstance(subscription.error, ZeroDivisionError) and live.running
    assert [entry.tick for entry in live.log] == [0, 10, 20]


def test_errors_of_calls_and_commands_reach_the_caller_and_are_not_logged(live: LiveSimulator) -> None:
    for name, arguments, rule in (
        ("set_effort", {"vehicle": "rov", "surge": 1.5}, r"1\.5"),
        ("fly", {}, "must be one of release, undock"),
        ("set_effort", {"vehicle": "rov", "warp": 1.0}, "'warp'"),
        ("release", {"vehicle": "rob"}, "vehicle = 'rob': must be one of rov"),
        ("place", {"vehicle": "rov", "position_world_m": [0.0, object(), 0.0]}, r"'place': position_world_m\[1\] is"),
    ):
        with pytest.raises(ValueError, match=rule):
            result(live.command(name, **arguments))
    with pytest.raises(ValueError, match=r"1\.5"):
        live.rov.set_effort(surge=1.5)
    assert len(live.log) == 0
    with pytest.raises(ZeroDivisionError):
        result(live.call(lambda sim: 1 // 0))
    assert live.running


def test_arguments_are_kept_as_they_were(live: LiveSimulator) -> None:
    position_m = np.array([1.0, 2.0, -3.0])
    future = live.command("place", vehicle="rov", position_world_m=position_m)
    position_m[:] = 0.0
    result(future)
    assert next(iter(live.log)).arguments["position_world_m"] == [1.0, 2.0, -3.0]


def test_only_a_paused_simulator_makes_single_steps(live: LiveSimulator) -> None:
    live.step(0)
    assert live.simulator.tick == 0
    with pytest.raises(ValueError, match="n = -1 steps"):
        live.step(-1)
    live.resume()
    with pytest.raises(ValueError, match="pause it first"):
        live.step(1)
    until(lambda: live.simulator.tick > 0)
    live.pause()
    tick = live.simulator.tick
    time.sleep(0.02)
    assert live.simulator.tick == tick
    assert live.factor == 0.0


def test_a_long_call_makes_it_late_and_says_so() -> None:
    with LiveSimulator("pool", speed=1.0) as live:
        live.call(lambda sim: time.sleep(0.4)).result()
        until(lambda: live.lateness > 0.35)
        until(lambda: live.slipped_s > 0.35)
        until(lambda: live.factor > 0.0)


def test_stopping_ends_what_waits_and_starting_goes_on() -> None:
    live = LiveSimulator("pool", paused=True)
    with pytest.raises(NotRunningError, match="start it first"):
        live.call(lambda sim: None)
    live.start()
    with pytest.raises(RuntimeError, match="already running"):
        live.start()
    errors: list[Exception] = []

    def wait() -> None:
        try:
            live.clock.wait(1.0)
        except NotRunningError as error:
            errors.append(error)

    waiter = threading.Thread(target=wait)
    waiter.start()
    time.sleep(0.02)
    live.stop()
    waiter.join(PATIENCE_S)
    assert len(errors) == 1
    assert not live.running
    with live:
        live.step(3)
    assert live.simulator.tick == 3


def test_after_a_failed_step_it_stands_still_until_it_is_reset() -> None:
    class Bursting(Simulator):
        def step(self, n: int = 1) -> None:
            if self.tick + n > 20:
                raise ValueError("the motion diverged")
            super().step(n)

    with LiveSimulator(Bursting("pool"), speed="max") as live:
        with pytest.raises(ValueError, match="diverged"):
            live.clock.wait(1.0)
        assert live.paused
        assert "diverged" in str(live.error)
        with pytest.raises(ValueError, match="diverged"):
            live.resume()
        with pytest.raises(ValueError, match="diverged"):
            live.step(1)
        live.reset()
        live.step(20)
        assert live.error is None


def dive(vehicle: SteeredVehicle, clock: Clock) -> None:
    """A mission that turns north and descends 1 m."""
    autopilot = Autopilot(vehicle)
    z_m = float(vehicle.pose.position_world_m[2]) - 1.0
    for _ in range(150):
        autopilot.steer(np.pi / 2, (0.0, 0.0), z_m)
        clock.wait(autopilot.period_s)


def test_a_mission_flies_as_on_a_simulator(live: LiveSimulator) -> None:
    sim = Simulator("pool")
    sim.rov.release()
    dive(sim.rov, sim)
    live.rov.release()
    with live.mission_clock() as clock:
        live.resume()
        dive(live.rov, clock)
        assert live.simulator.save_state() == sim.save_state()
    until(lambda: live.simulator.tick > sim.tick)  # the simulator runs again


def test_a_clock_keeps_its_period_while_the_mission_thinks(live: LiveSimulator) -> None:
    clock = live.clock
    clock.wait(0.0)
    live.step(3)  # the mission is computing
    waiter = threading.Thread(target=clock.wait, args=[0.05])
    waiter.start()
    live.step(6)
    waiter.join(0.05)
    assert waiter.is_alive()
    live.step(1)
    waiter.join(PATIENCE_S)
    assert not waiter.is_alive()


INTERRUPTED = """
import random, signal
from uwsim.live import LiveSimulator

for number in (signal.SIGALRM, signal.SIGINT):
    signal.signal(number, signal.default_int_handler)  # the parent process may ignore SIGINT
moments = random.Random(1)
try:
    with LiveSimulator("pool") as live:
        for _ in range(60):
            try:
                signal.setitimer(signal.ITIMER_REAL, moments.uniform(1e-6, 1e-4))
                live.clock.wait(1000.0)
            except KeyboardInterrupt:
                pass
        live.clock.wait(0.1)
        print("up", flush=True)
        live.clock.wait(1000.0)
except KeyboardInterrupt:
    print("interrupted", live.running)
LiveSimulator("pool", speed="max").start()
"""


def test_an_interrupt_at_any_moment_of_a_wait_is_survived_and_a_program_may_end_without_stopping() -> None:
    command = [sys.executable, "-c", INTERRUPTED]
    child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        assert child.stdout is not None
        assert child.stdout.readline() == "up\n"
        child.send_signal(signal.SIGINT)  # Ctrl-C ends a program that waits
        said = child.communicate(timeout=PATIENCE_S)
    finally:
        child.kill()
    assert (said, child.returncode) == (("interrupted False\n", ""), 0)
