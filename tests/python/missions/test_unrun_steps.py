"""A step that a mission makes and never runs is an error before the flight, with its file and line."""

from functools import partial
from pathlib import Path

import numpy as np
import pytest

from uwsim.flight.mission_file import MissionError, load_mission
from uwsim.missions import OwnVehicle, drive, goto, hold, parallel, unrun_steps, until, wait
from uwsim.missions.run import made
from uwsim.missions.unrun_steps import require_steps_run

HERE = (0.0, 0.0, -2.0)
BEGUN = """from uwsim import missions
from uwsim.missions import goto, hold, parallel, until, wait
from uwsim.missions.planners.area_pilot import AreaPilot
HERE = (0.0, 0.0, -2.0)
def leg(vehicle):
    yield from goto(vehicle, HERE)
def forgets(vehicle):
    yield wait(1.0)
    goto(vehicle, HERE)
def mission(vehicle):
    yield wait(1.0)
    """
FORGETFUL = {
    "a step": "goto(vehicle, HERE)",
    "a wait": "wait(1.0)",
    "by module": "missions.hold(vehicle, 1.0)",
    "its own": "if vehicle.all_stopped:\n        leg(vehicle)",
    "in a part": "yield from parallel(hold(vehicle, 1.0), forgets(vehicle))",
    "all at once": "parallel(hold(vehicle, 1.0), leg(vehicle))",
    "an inner one": "def lap():\n        yield from goto(vehicle, HERE)\n    lap()",
    "a method": "pilot = AreaPilot(vehicle, None)\n    pilot.clear()",
    "a choice": "goto(vehicle, HERE) if vehicle.all_stopped else hold(vehicle, 1.0)",
    "a list": "[goto(vehicle, place) for place in (HERE, HERE)]",
    "what it asks for": "if until(lambda: vehicle.all_stopped, timeout_s=1.0):\n        vehicle.undock()",
    "to wait in a loop": "while vehicle.all_stopped or not until(lambda: True):\n        yield wait(1.0)",
    "what it stores": "step = goto(vehicle, HERE)\n    if step:\n        vehicle.undock()",
}


@pytest.mark.parametrize("forgotten", FORGETFUL.values(), ids=FORGETFUL.keys())
def test_a_step_that_is_never_run_is_found(forgotten, tmp_path: Path):
    (tmp_path / "m.py").write_text(BEGUN + forgotten)
    with pytest.raises(MissionError, match=r"m.py:\d+: [\w.]+\(\.\.\.\) is made and never run"):
        load_mission(tmp_path / "m.py")


class Forgets:
    def __init__(self, vehicle):
        self.vehicle = vehicle

    def lap(self):
        yield from goto(self.vehicle, HERE)

    def steps(self):
        yield wait(1.0)
        self.lap()


def leg(vehicle, forgets=True):
    yield from goto(vehicle, HERE)
    if forgets:
        hold(vehicle)


@pytest.mark.parametrize("mission", [Forgets, leg, partial(leg, forgets=False)])
def test_it_is_found_in_every_kind_of_mission(mission):
    with pytest.raises(ValueError, match=r"test_unrun_steps.py:\d+: [\w.]+\(\.\.\.\) is made and never run"):
        made(mission, {})


def test_steps_that_run_are_accepted():
    def mission(vehicle: OwnVehicle):
        vehicle.undock()
        vehicle.telemetry()
        ways = [goto(vehicle, HERE), hold(vehicle, 1.0)]
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
        yield from parallel(hold(vehicle), goto(vehicle, HERE))

    require_steps_run(mission)


def test_a_step_in_an_imported_file_is_found(tmp_path: Path):
    (tmp_path / "legs_of_mine.py").write_text(
        "from uwsim.missions import turn_to, wait\ndef lap(vehicle):\n    turn_to(vehicle, 1.0)\n    yield wait(1.0)\n"
    )
    path = tmp_path / "m.py"
    path.write_text("from legs_of_mine import lap\ndef mission(vehicle):\n    yield from lap(vehicle)\n")
    with pytest.raises(MissionError, match=r"legs_of_mine.py:3: turn_to\(\.\.\.\) is made and never run"):
        load_mission(path)


def test_libraries_that_know_nothing_of_missions_are_not_read(monkeypatch: pytest.MonkeyPatch):
    def mission(vehicle):
        yield wait(float(np.median([1.0, 2.0])))

    read, tree = [], unrun_steps._tree
    monkeypatch.setattr(unrun_steps, "_tree", lambda function: read.append(function.__name__) or tree(function))
    require_steps_run(mission)
    assert read == ["mission"]
