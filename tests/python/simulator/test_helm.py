"""The rules of who steers a vehicle, and of what becomes of other commands: the tables in uwsim.simulator.helm."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.scenario import Scenario, load
from uwsim.scenario.spec.battery import Failsafe
from uwsim.scenario.spec.vehicle import load_vehicle
from uwsim.simulator import helm
from uwsim.simulator.helm import AllStopWarning, FailsafeWarning, Lease, Reason, Source
from uwsim.simulator.vehicle import Vehicle

PLACE = (0.0, 0.0, -2.0)
MODELS = {"set_fins": "remus100", "set_thrusters": "bluerov2_heavy", "set_wrench": "bluerov2_heavy"}
"""The models that commands need; all others move the scenario's own vehicle."""


def table(column: str) -> dict[tuple[str, str], str]:
    """Return a table of the module's docstring, {(who steers, who or what commands): outcome}, found by a column."""
    tables = re.findall(r"(?:^\|.*\n)+", helm.__doc__ or "", flags=re.MULTILINE)
    (found,) = [text for text in tables if column in text.splitlines()[0]]
    rows = [[cell.strip(" `") for cell in line.strip("|").split("|")] for line in found.splitlines()]
    return {(row[0], name): cell for row in rows[2:] for name, cell in zip(rows[0][1:], row[1:], strict=True)}


LEASES, COMMANDS = table("`CLIENT`"), table("`place`")


@cache
def pool(model: str) -> Scenario:
    """Return the pool with a vehicle that a leak makes surface."""
    plain = load("pool").with_changes(vehicle_model=load_vehicle(model) if model else None)
    guard = Failsafe(leak_then="surface")
    data = {key: getattr(plain, key) for key in type(plain).model_fields}
    entry = {**dict(plain.vehicles[0]), "failsafe": guard, "start": {"position_m": PLACE}}
    return Scenario.model_validate({**data, "vehicles": [entry]})


def afloat(model: str = "") -> Simulator:
    return Simulator(pool(model), threads=1)


def steering(sim: Simulator, who: str) -> Lease | None:
    """Let a source, by its name in the table, steer the vehicle; return its lease, if it has one."""
    rov, lease = sim.rov, None
    if who == "HOLD":
        rov.command("hold", heading=True)
    elif who == "FAILSAFE":
        sim.faults.inject("leak", kg_per_s=0.5)
        sim.advance(2.0)
    elif who == "ALL_STOP":
        rov.all_stop()
    elif who != "none":
        lease = rov.helm.take(Source[who], who)
    assert rov.helm.steers is (Source.NONE if who == "none" else Source[who])
    return lease


@pytest.mark.parametrize(("who", "other"), LEASES)
def test_who_may_take_the_helm(who: str, other: str) -> None:
    sim = afloat()
    before, source = steering(sim, who), Source[other]
    taken: Lease | None = None
    try:
        taken = steering(sim, other) if source >= Source.FAILSAFE else sim.rov.helm.take(source, other)
        outcome = "takes" if sim.rov.helm.steers is source else "waits"
    except ValueError as error:
        outcome = "refused"
        assert ("vehicle 'rov': " in str(error) and before is None) or before.is_held
    except AssertionError:
        outcome = "waits"  # a failsafe or all stop that does not steer
    assert outcome == LEASES[who, other]
    if before is not None and taken is not None:
        assert before.is_held == (before.source >= Source.PILOT and before.source is not source)


def effect(sim: Simulator, command: str, arguments: dict[str, Any], who: str) -> str:
    """Return what becomes of a command, in the words of the table."""
    rov, journalled = sim.rov, []

    class Observer:
        due_tick = 2**62

        def observe(self) -> None: ...

        def commanded(self, name: str, arguments: dict[str, Any]) -> None:
            journalled.append(name)

    before = drive(sim)
    sim.journal.attach(Observer())
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        try:
            rov.command(command, **arguments)
        except ValueError as error:
            assert f"vehicle 'rov': {command}: " in str(error)
            assert not journalled, "what is refused changes nothing"
            assert drive(sim) == before
            return "refused"
    assert journalled[-1:] == [command]
    if command == "place":
        assert np.allclose(rov.pose.position_world_m, arguments["position_world_m"])
        return "places"
    moves = any(np.any(list(value.values()) if isinstance(value, dict) else value) for value in arguments.values())
    if who in ("ALL_STOP", "FAILSAFE"):
        assert drive(sim) == before, "what is overridden moves nothing"
        kind = AllStopWarning if who == "ALL_STOP" else FailsafeWarning
        assert [each.category for each in warned] == ([kind] if moves or who == "FAILSAFE" else [])
        return "overridden"
    assert not warned
    if who == "AUTOPILOT":
        assert not any(drive(sim))
        return "stops"
    if command == "hold":
        assert rov.helm.steers is Source.HOLD
        return "steers"
    assert any(drive(sim)) == moves
    return "joins" if rov.helm.steers is Source.HOLD else "steers"


def drive(sim: Simulator) -> list[float]:
    """Return what is commanded of the actuators; for fins, where they are after a while."""
    rov, state = sim.rov, sim.save_state()
    found = [*rov.effort.tolist(), *(each.command for each in rov.thrusters.values())]
    if rov.fins:
        sim.step(9)
        found += rov.fins.values()
        sim.restore_state(state)
    return found


EFFORT: dict[str, Any] = {"surge": 0.5}
OTHERS: dict[str, Callable[[Vehicle, float], dict[str, Any]]] = {
    "set_wrench": lambda rov, value: {"force_body_n": [10.0 * value, 0.0, 0.0]},
    "set_thrusters": lambda rov, value: {"commands": dict.fromkeys(rov.thrusters, value)},
    "set_fins": lambda rov, value: {"angles_rad": dict.fromkeys(rov.fins, 0.1 * value)},
}


@pytest.mark.parametrize(("who", "what"), COMMANDS)
def test_what_becomes_of_a_command(who: str, what: str) -> None:
    of_column: dict[str, list[tuple[str, dict[str, Any] | float]]] = {
        "set_effort": [("set_effort", EFFORT)],
        "another command": [(name, 1.0) for name in OTHERS],
        "a command that stops": [(name, 0.0) for name in OTHERS],
        "hold": [("hold", {"depth": True})],
        "place": [("place", {"position_world_m": (1.0, 0.0, -3.0)})],
    }
    for command, given in of_column[what]:
        sim = afloat(MODELS.get(command, ""))
        steering(sim, who)
        arguments = OTHERS[command](sim.rov, given) if isinstance(given, float) else given
        assert effect(sim, command, arguments, who) == COMMANDS[who, what], command


def test_an_effort_of_zero_stops_what_it_does_not_join() -> None:
    for who in ("HOLD", "AUTOPILOT", "FAILSAFE", "ALL_STOP"):
        sim = afloat()
        steering(sim, who)
        column = "set_effort" if who == "HOLD" else "a command that stops"
        assert effect(sim, "set_effort", {}, who) == COMMANDS[who, column]


def test_the_loser_learns_the_reason() -> None:
    lost: list[Reason] = []
    rov = afloat().rov
    for source in (Source.CLIENT, Source.FLIGHT, Source.PILOT, Source.PILOT, Source.AUTOPILOT):
        rov.helm.take(source, source.name, lost.append)
    assert lost == [Reason.REPLACED, Reason.PILOT, Reason.PILOT]
    assert [lease.source for lease in rov.helm.leases] == [Source.PILOT, Source.AUTOPILOT]
