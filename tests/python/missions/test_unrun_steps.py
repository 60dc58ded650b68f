"""A step that a mission makes and never runs is an error before the flight, with its file and line."""

from functools import partial
from pathlib import Path

import pytest

from uwsim import missions
from uwsim.flight.mission_file import MissionError, load_mission
from uwsim.missions import OwnVehicle, drive, goto, hold, parallel, until, wait
from uwsim.missions.planners.area_pilot import AreaPilot
from uwsim.missions.run import made
from uwsim.missions.unrun_steps import require_steps_run

HERE = (0.0, 0.0, -2.0)


def leg(vehicle):
    yield from goto(vehicle, HERE)


def forgets_a_step(vehicle):
    yield wait(1.0)
    goto(vehicle, HERE)


def forgets_a_wait(vehicle):
    yield wait(1.0)
    wait(1.0)


def forgets_by_module(vehicle):
    missions.hold(vehicle, 1.0)
    yield wait(1.0)


def forgets_its_own(vehicle):
    yield wait(1.0)
    if vehicle.all_stopped:
        leg(vehicle)


def forgets_in_a_part(vehicle):
    yield from parallel(hold(vehicle, 1.0), forgets_a_step(vehicle))


def forgets_all_at_once(vehicle):
    yield wait(1.0)
    parallel(hold(vehicle, 1.0), leg(vehicle))


def forgets_an_inner_one(vehicle):
    def lap():
        yield from goto(vehicle, HERE)

    yield wait(1.0)
    lap()


def forgets_a_method(vehicle: OwnVehicle):
    pilot = AreaPilot(vehicle, None)
    yield wait(1.0)
    pilot.clear()


def forgets_a_choice(vehicle):
    yield wait(1.0)
    goto(vehicle, HERE) if vehicle.all_stopped else hold(vehicle, 1.0)


def forgets_a_list(vehicle):
    yield wait(1.0)
    [goto(vehicle, place) for place in (HERE, HERE)]


def forgets_what_it_asks_for(vehicle):
    yield wait(1.0)
    if until(lambda: vehicle.all_stopped, timeout_s=1.0):
        vehicle.undock()


def forgets_to_wait_in_a_loop(vehicle):
    while vehicle.all_stopped or not until(lambda: vehicle.all_stopped):
        yield wait(1.0)


def forgets_what_it_stores(vehicle):
    yield wait(1.0)
    step = goto(vehicle, HERE)
    if step:
        vehicle.undock()


class ForgetsInAClass:
    def __init__(self, vehicle):
        self.vehicle = vehicle

    def lap(self):
        yield from goto(self.vehicle, HERE)

    def steps(self):
        yield wait(1.0)
        self.lap()


FORGETFUL = {name: value for name, value in globals().items() if name.lower().startswith("forgets")}
FORGETFUL["partial"] = partial(forgets_a_step)


@pytest.mark.parametrize("mission", FORGETFUL.values(), ids=FORGETFUL.keys())
def test_a_step_that_is_never_run_is_found(mission):
    with pytest.raises(ValueError, match=r"test_unrun_steps.py:\d+: [\w.]+\(\.\.\.\) is made and never run"):
        made(mission, {})


def test_steps_that_run_are_accepted():
    def mission(vehicle: OwnVehicle):
        vehicle.undock()
        vehicle.telemetry()
        ways = [leg(vehicle), hold(vehicle, 1.0)]
        for way in ways:
            yield from way
        reached = yield from until(lambda: vehicle.all_stopped, timeout_s=1.0)
        if reached:
            yield wait(1.0)
        there = goto(vehicle, HERE)
        while not (done := drive(there, vehicle)):
            yield wait(1.0)
        either = goto(vehicle, HERE) if done else hold(vehicle, 1.0)
        if either and vehicle.all_stopped:
            yield from either
        yield from wait(1.0)
        sorted(ways, key=lambda way: hold(vehicle))
        yield from parallel(leg(vehicle), goto(vehicle, HERE))

    require_steps_run(mission)


def test_a_step_in_an_imported_file_is_found(tmp_path: Path):
    (tmp_path / "legs_of_mine.py").write_text(
        "from uwsim.missions import turn_to, wait\ndef lap(vehicle):\n    turn_to(vehicle, 1.0)\n    yield wait(1.0)\n"
    )
    path = tmp_path / "m.py"
    path.write_text("from legs_of_mine import lap\ndef mission(vehicle):\n    yield from lap(vehicle)\n")
    with pytest.raises(MissionError, match=r"legs_of_mine.py:3: turn_to\(\.\.\.\) is made and never run"):
        load_mission(path)
