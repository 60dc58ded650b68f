"""The order of events within one tick, as given by the table in uwsim.base.agenda."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from uwsim import Simulator, _core
from uwsim.base.agenda import next_tick
from uwsim.channels import Table
from uwsim.link import Carrier
from uwsim.live import LiveSimulator
from uwsim.scenario import Scenario, load
from uwsim.scenario.spec.battery import Failsafe as FailsafeSpec
from uwsim.simulator.failures import Failsafe, Faults
from waiting import until

DUE = 100  # a tick at which everything is due; failsafes check every 0.5 s
SENSOR_FAULT = {"kind": "sensor", "sensor": "depth", "at_s": 0.5}


class Watcher:
    """An observer that appends what it sees to a trace."""

    def __init__(self, name: str, sim: Simulator, trace: list[str], period: int = DUE) -> None:
        self.name, self.sim, self.trace, self.period, self.due_tick = name, sim, trace, period, period

    def observe(self) -> None:
        self.trace.append(f"{self.name} looks")
        self.due_tick += self.period

    def commanded(self, name: str, arguments: dict[str, Any]) -> None:
        if name == "set_effort":
            self.trace.append(f"{self.name} learns of {name}")


@pytest.fixture
def trace(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Record, in order, the actions of all simulators created after this point."""
    lines: list[str] = []

    def spy(owner: type, method: str, line: Callable[[Any], str]) -> None:
        original = getattr(owner, method)

        def noted(self: Any, *arguments: Any) -> Any:
            lines.append(line(self))
            return original(self, *arguments)

        monkeypatch.setattr(owner, method, noted)

    spy(Carrier, "act", lambda carrier: "the link delivers")
    spy(Faults, "act", lambda faults: "faults act")
    spy(Failsafe, "act", lambda failsafe: f"the failsafe of {failsafe._vehicle.name} acts")
    spy(_core.Simulation, "step", lambda core: "the world steps")
    return lines


def everything(**link: str) -> Scenario:
    """Return a scenario of two vehicles with failsafes and a fault, optionally with a link."""
    pair, guard = load("pair").with_changes(modem=link.get("modem")), FailsafeSpec(leak_then="surface")
    vehicles = [
        {**dict(entry), "failsafe": guard, "start": {"position_m": [8.0 * k, 0.0, -5.0]}}
        for k, entry in enumerate(pair.vehicles)
    ]
    data = {key: getattr(pair, key) for key in type(pair).model_fields}
    return Scenario.model_validate({**data, "vehicles": vehicles, "faults": [SENSOR_FAULT]})


def test_the_order_within_one_tick(trace: list[str]) -> None:
    sim = Simulator(everything(modem="s2cm_hs"), threads=1)
    carrier = Carrier(sim, Table(sim)).start()
    for name in ("the first", "the second"):
        sim.journal.attach(Watcher(name, sim, trace))
    sim.step(DUE - 1)
    sim.link.send("station", "rov", "anything", b"makes the link due at each tick")
    trace.clear()
    sim.step()
    sim.rov.set_effort(surge=0.5)
    sim.step()
    carrier.close()
    assert trace == [
        "the world steps",
        "the first looks",
        "the second looks",
        "the link delivers",
        "the first learns of set_effort",
        "the second learns of set_effort",
        "faults act",
        "the failsafe of rov acts",
        "the failsafe of scout acts",
        "the world steps",
        "the link delivers",
    ]


def test_the_order_does_not_depend_on_how_many_steps_are_made_at_once(trace: list[str]) -> None:
    def acted(parts: list[int]) -> list[str]:
        sim = Simulator(everything(), threads=1)
        sim.journal.attach(Watcher("the first", sim, trace, period=30))
        sim.journal.attach(Watcher("the second", sim, trace, period=DUE))
        trace.clear()
        for steps in parts:
            sim.step(steps)
        return [line for line in trace if line != "the world steps"]

    assert acted([250]) == acted([1] * 250) == acted([99, 1, 1, 149])
    idle = Simulator("pool", threads=1)
    trace.clear()
    idle.step(500)
    assert trace == ["the world steps"], "nothing is due"


def test_readings_of_a_live_simulator_come_before_the_commands_of_their_tick() -> None:
    seen: list[tuple[int, float]] = []
    with LiveSimulator(Simulator("pool", threads=1), speed="max", paused=True) as live, live.mission_clock() as clock:
        live.every(0.05, lambda sim: (sim.tick, float(sim.rov.effort[0])), seen.append)
        live.rov.release()
        live.resume()
        for k in range(1, 6):
            clock.wait(0.05)
            live.command("set_effort", vehicle="rov", surge=0.1 * k).result()
        clock.wait(0.005)
    expected = [(10 * k, pytest.approx(0.1 * (k - 1))) for k in range(1, 6)]
    assert seen[-5:] == expected


def test_a_sink_may_pause_a_live_simulator_at_its_tick() -> None:
    with LiveSimulator(Simulator("pool", threads=1), speed="max", paused=True) as live:
        live.every(0.25, lambda sim: sim.tick, lambda tick: live.pause() if tick else None)
        live.resume()
        until(lambda: live.paused)
        assert live.read(lambda sim: sim.tick).result() == live.tick == 50


def test_what_an_observer_makes_fail_begins_and_ends_at_its_ticks() -> None:
    class Breaker(Watcher):
        def observe(self) -> None:
            super().observe()
            self.sim.faults.inject("current", velocity_world_m_s=[0.2, 0.0, 0.0], for_s=0.05)

    def events(parts: list[int]) -> list[tuple[str, int]]:
        sim = Simulator("pool", threads=1)
        sim.journal.attach(Breaker("the breaker", sim, [], period=30))
        for steps in parts:
            sim.step(steps)
        return [(event.name, event.tick) for event in sim.events]

    assert events([59]) == events([1] * 59) == [("fault", 30), ("fault_ends", 40)]


@given(st.integers(0, 10**6), st.integers(1, 10**10), st.integers(1, 10**8))
def test_the_next_tick_is_the_first_at_a_multiple_or_after(tick: int, period_ns: int, step_ns: int) -> None:
    due = next_tick(tick, period_ns, step_ns)
    assert due > tick and (due * step_ns) // period_ns > (tick * step_ns) // period_ns
    assert ((due - 1) * step_ns) // period_ns == (tick * step_ns) // period_ns
