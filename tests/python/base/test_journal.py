"""A journal records every command once, when it takes effect, and calls its observers at the ticks they request."""

from typing import Any

import numpy as np

from uwsim import Simulator
from uwsim.base.arguments import plain
from uwsim.base.commands import bound_command


class Watcher:
    def __init__(self, sim: Simulator, period: int = 10**9) -> None:
        self.sim, self.period, self.due_tick = sim, period, period
        self.seen: list[tuple[int, str, dict[str, Any]]] = []
        self.looked: list[int] = []

    def observe(self) -> None:
        self.looked.append(self.sim.tick)
        self.due_tick += self.period

    def commanded(self, name: str, arguments: dict[str, Any]) -> None:
        self.seen.append((self.sim.tick, name, arguments))


def fly(sim: Simulator) -> None:
    rov = sim.rov
    rov.undock()
    sim.step(5)
    rov.set_effort(surge=0.5)
    rov.sonar.aim(-0.4)
    sim.step(7)
    rov.lamps["front"].on = True
    rov.set_wrench((1.0, 0.0, 2.0))
    sim.set_optics(sun_elevation_deg=20.0)
    sim.step(9)
    rov.place(np.array([0.0, 0.0, -3.0]), velocity_body=(0.1, 0.0, 0.0, 0.0, 0.0, 0.0))
    sim.step(20)


def test_what_the_journal_saw_repeated_is_the_same_run() -> None:
    sim, again = Simulator("pool", seed=4), Simulator("pool", seed=4)
    watcher = Watcher(sim)
    sim.journal.attach(watcher)
    fly(sim)
    names = [name for _, name, _ in watcher.seen]
    assert names == ["undock", "set_effort", "aim", "set_lamp", "set_wrench", "set_parameters", "place"]
    for tick, name, arguments in watcher.seen:
        again.step(tick - again.tick)
        bound_command(name, plain(arguments, name))(again)
    again.step(sim.tick - again.tick)
    state = sim.save_state()
    assert again.save_state() == state
    watcher.seen.clear()
    sim.restore_state(state)
    sim.reset(seed=9)
    assert [entry[1:] for entry in watcher.seen] == [("restore_state", {"state": state}), ("reset", {"seed": 9})]


def test_observers_are_asked_at_their_ticks_and_change_nothing() -> None:
    sim, alone = Simulator("pool", seed=4), Simulator("pool", seed=4)
    threes, fours = Watcher(sim, 3), Watcher(sim, 4)
    sim.journal.attach(threes)
    sim.journal.attach(fours)
    fly(sim)
    fly(alone)
    assert threes.looked == list(range(3, 42, 3)) and fours.looked == list(range(4, 42, 4))
    assert sim.save_state() == alone.save_state()
    sim.journal.detach(threes)
    sim.step(3)
    assert threes.looked[-1] == 39
