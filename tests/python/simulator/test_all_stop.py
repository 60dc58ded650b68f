"""All stop overrides every way of commanding a vehicle: while it is set, vehicles move as if uncommanded."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from all_stop_world import DRIVES, at_rest, motion, scenario
from uwsim import Simulator
from uwsim.live import COMMANDS
from uwsim.missions import LawnMowerPlan, StoppedError, dive_to, follow, goto, hold, mow, run, turn_to, wait
from uwsim.navigation.control.autopilot import Autopilot
from uwsim.navigation.control.controller import Controller, VelocityHold
from uwsim.navigation.control.path import PathFollower
from uwsim.simulator.helm import AllStopWarning
from uwsim.simulator.vehicle import Vehicle

STEPS = 200

MOVING: dict[str, tuple[str, dict[str, Any]]] = {
    "set_effort": ("forces", {"surge": 1.0, "yaw": -0.5}),
    "set_wrench": ("thrusters", {"force_body_n": [100.0, 0.0, 0.0], "torque_body_nm": [0.0, 0.0, 5.0]}),
    "set_thrusters": ("fins", {"commands": {"propeller": 1.0}}),
    "set_fins": ("fins", {"angles_rad": {"top": 0.2, "port": -0.2}}),
}
"""Commands that move a vehicle, each with a vehicle it moves."""
FRAMES = "servo_frames"
"""The steps of an autopilot; tested separately below."""
REFUSED = {"hold", "hold_at", "set_joints", "drop"}
"""Commands that are refused while all stop is set; see test_holds.py, test_arm.py, test_droppers.py."""
IN_DOCK = ("release", "undock")
"""Commands that release a vehicle from its dock; tested separately below."""
FREE = {
    "dock", "override_failsafe", "all_stop", "aim", "set_lamp", "aim_camera",  # only into the dock
    "place", "inject_fault", "end_fault", "set_parameter", "set_parameters", "reset_parameters", "set_optics",  # world
    "apply_wrench", "push_object", "set_winch", "cut_tether", "set_object_winch", "cut_object_tether",
    "start_navigation", "link_send", "note", "reload",
}  # fmt: skip
"""Commands that all stop does not affect. Commands sent over a link are checked on arrival."""


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return scenario(tmp_path_factory.mktemp("drives"))


@pytest.fixture
def sim(path: Path) -> Simulator:
    """A simulator whose vehicles have just been stopped while moving at full effort."""
    sim = Simulator(path, seed=4)
    swing(sim)
    return sim


def swing(sim: Simulator) -> None:
    for rov in sim.vehicles.values():
        rov.set_effort(surge=0.8, yaw=0.3)
    sim.rov.set_thrusters({"front_left": 0.6})
    sim.vehicles["fins"].set_fins({"top": 0.1})
    sim.step(STEPS)
    for rov in sim.vehicles.values():
        rov.all_stop()


@pytest.fixture(scope="module")
def alone(path: Path) -> bytes:
    """The vehicles' motion if no commands are given."""
    sim = Simulator(path, seed=4)
    swing(sim)
    sim.step(STEPS)
    return motion(sim)


def test_every_command_that_there_is_has_been_thought_of() -> None:
    assert set(COMMANDS) == set(MOVING) | set(IN_DOCK) | REFUSED | FREE | {FRAMES}


def test_nothing_aboard_moves_a_stopped_vehicle(sim: Simulator) -> None:
    for rov in sim.vehicles.values():
        rov.steer_silently([1.0] * 6)  # as the vehicle's failsafe would
    sim.step(STEPS)
    assert at_rest(sim)


def test_all_stop_puts_every_drive_to_rest(sim: Simulator) -> None:
    assert not any(state.command for rov in sim.vehicles.values() for state in rov.thrusters.values())
    sim.advance(60.0)
    assert at_rest(sim)
    assert all(np.linalg.norm(rov.velocity.linear_body_m_s[:2]) < 0.1 for rov in sim.vehicles.values())


@pytest.mark.parametrize("name", MOVING)
def test_no_command_moves_a_stopped_vehicle_and_the_caller_is_warned_once(
    sim: Simulator, alone: bytes, name: str
) -> None:
    vehicle, arguments = MOVING[name]
    moved = Simulator(sim.scenario, seed=4)
    COMMANDS[name](moved, vehicle=vehicle, **arguments)
    moved.step()
    assert not at_rest(moved), "it would move it"
    with pytest.warns(AllStopWarning, match=f"vehicle '{vehicle}': all stop is set") as warned:
        for _ in range(STEPS):
            COMMANDS[name](sim, vehicle=vehicle, **arguments)
            sim.step()
    assert len(warned) == 1
    assert at_rest(sim) and motion(sim) == alone


def test_an_autopilots_frames_do_not_move_a_stopped_vehicle(sim: Simulator, alone: bytes) -> None:
    frames = np.full((STEPS, 32), 1800, "<u2").tobytes()

    def play(sim: Simulator) -> None:
        given = {"vehicle": "thrusters", "frame": "vectored_6dof", "from_tick": sim.tick, "frames": frames}
        COMMANDS[FRAMES](sim, **given)
        sim.step(STEPS)

    play(sim)
    assert at_rest(sim) and motion(sim) == alone
    sim.vehicles["thrusters"].all_stop(False)
    play(sim)
    assert not at_rest(sim)


@pytest.mark.parametrize("name", MOVING)
def test_what_is_wrong_is_still_refused(sim: Simulator, name: str) -> None:
    wrong = {"set_effort": {"surge": 2.0}, "set_wrench": {"force_body_n": [math.nan] * 3},
             "set_thrusters": {"commands": {"none": 1.0}}, "set_fins": {"angles_rad": {"top": 99.0}}}  # fmt: skip
    with pytest.raises(ValueError, match="must"):
        COMMANDS[name](sim, vehicle="fins", **wrong[name])
    sim.step(STEPS)
    assert at_rest(sim)


@pytest.mark.parametrize("name", IN_DOCK)
def test_a_stopped_vehicle_stays_in_its_dock(name: str) -> None:
    sim = Simulator("pool")
    sim.rov.all_stop()
    with pytest.raises(ValueError, match=f"{name}: all stop is set"):
        COMMANDS[name](sim, vehicle="rov")
    assert not sim.rov.released
    sim.rov.all_stop(False)
    COMMANDS[name](sim, vehicle="rov")
    assert sim.rov.released


def test_after_its_release_a_vehicle_rests_until_the_next_command(sim: Simulator) -> None:
    for name in DRIVES:
        sim.vehicles[name].all_stop(False)
    sim.step(STEPS)
    assert at_rest(sim)
    sim.vehicles["forces"].set_effort(surge=0.5)
    assert sim.vehicles["forces"].effort[0] == 0.5
    assert [event.name for event in sim.events] == ["all_stop"] * 3 + ["all_stop_ends"] * 3


@pytest.mark.parametrize("on", [1, None, "false"])
def test_all_stop_is_set_or_not(sim: Simulator, on: object) -> None:
    with pytest.raises(ValueError, match=r"all_stop\.on = .*: must be True or False"):
        sim.rov.all_stop(on)  # type: ignore[arg-type]
    assert sim.rov.all_stopped


# Controllers, missions, failsafes


def holding_velocity(rov: Vehicle) -> Callable[[], object]:
    held = VelocityHold(rov, 0.05)
    return lambda: rov.set_effort(**held.efforts(np.array([0.5, 0, 0.2, 0, 0, 0])))


STEERED: dict[str, Callable[[Vehicle], Callable[[], object]]] = {
    "Controller": lambda rov: partial(Controller(rov, 0.05).hold, (20.0, 0.0, -2.0), 1.0),
    "PathFollower": lambda rov: PathFollower(Controller(rov, 0.05), [(0, 0, -5), (20, 5, -4)], 0.5).steer,
    "VelocityHold": holding_velocity,
    "Autopilot": lambda rov: partial(Autopilot(rov, 0.05).steer, 1.0, (0.5, 0.0), -2.0),
}


@pytest.mark.parametrize("way", [*STEERED, "a mission's efforts"])
def test_what_steers_does_not_move_a_stopped_vehicle(sim: Simulator, alone: bytes, way: str) -> None:
    rov = sim.vehicles["forces"]
    steer = STEERED[way](rov) if way in STEERED else lambda: rov.set_effort(surge=1.0, heave=0.5)

    def mission(vehicle: Any) -> Any:
        for _ in range(STEPS // 10):
            steer()
            yield wait(10 * sim.step_s)

    with pytest.warns(AllStopWarning):
        run(mission, rov, sim)
    assert at_rest(sim) and motion(sim) == alone


STEPPED: dict[str, Callable[[Any], Any]] = {
    "goto": lambda vehicle: goto(vehicle, (20.0, 0.0, -2.0)),
    "dive_to": lambda vehicle: dive_to(vehicle, 12.0),
    "turn_to": lambda vehicle: turn_to(vehicle, 2.0),
    "hold": lambda vehicle: hold(vehicle, 60.0),
    "follow": lambda vehicle: follow(vehicle, [(0.0, 0.0, -5.0), (20.0, 5.0, -5.0)]),
    "mow": lambda vehicle: mow(vehicle, LawnMowerPlan([[-15, -9], [15, -9], [15, 9], [-15, 9]])),
}


@pytest.mark.parametrize("step", STEPPED)
def test_a_mission_ends_with_the_reason_when_its_vehicle_is_stopped(path: Path, step: str) -> None:
    sim = Simulator(path)
    vehicle = sim.vehicles["forces"]

    class Clock:
        time_s = property(lambda self: sim.time_s)

        def wait(self, duration_s: float) -> None:
            sim.wait(duration_s)
            if not vehicle.all_stopped:
                assert not at_rest(sim)
                vehicle.all_stop()

    def mission(vehicle: Any) -> Any:
        yield from STEPPED[step](vehicle)

    with pytest.raises(StoppedError, match=r"^all stop is set$"):
        run(mission, vehicle, Clock())
    assert at_rest(sim)


@pytest.mark.parametrize("then", ["hold", "surface", "return"])
def test_no_failsafe_moves_a_stopped_vehicle_and_it_begins_where_it_is_released(tmp_path: Path, then: str) -> None:
    sim = Simulator(scenario(tmp_path, failsafe=f"{{battery_percent: 100, battery_then: {then}}}"))
    still = Simulator(scenario(tmp_path, failsafe="{battery_percent: 100, battery_then: go_on}"))
    for each in (sim, still):
        each.parameters["water.current_world_m_s"] = [0.3, 0.0, 0.0]
        each.vehicles["forces"].place([-20.0, -5.0, -8.0])
        for rov in each.vehicles.values():
            rov.all_stop()
    sim.step(7), still.step(7)
    restored = Simulator(sim.scenario)
    sim.advance(20.0), still.advance(20.0)
    assert {rov.failsafe.state for rov in sim.vehicles.values()} == {then}
    assert at_rest(sim) and motion(sim) == motion(still)
    restored.restore_state(sim.save_state())
    x_m = sim.vehicles["forces"].pose.position_world_m[0]
    for each in (sim, restored):
        each.vehicles["forces"].all_stop(False)
        each.advance(3.0)
    assert motion(restored) == motion(sim) and not at_rest(sim)
    if then == "hold":
        sim.advance(20.0)
        assert abs(sim.vehicles["forces"].pose.position_world_m[0] - x_m) < 1.5, "it holds where it was released"


# Log, recording, state
