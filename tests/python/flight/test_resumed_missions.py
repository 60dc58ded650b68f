"""A mission restored from a saved state continues as if it had not been interrupted."""

import copy
import json
from functools import partial
from itertools import pairwise

import numpy as np
import pytest

from resumed_mowing import mow_twice
from test_missions import PLAN, ScriptedVehicle
from uwsim import Simulator
from uwsim.missions import (
    AdaptiveLawnMower,
    LawnMowerPlan,
    ObstacleMemory,
    OwnVehicle,
    ResumableMission,
    Steps,
    drive,
    run,
    wait,
)
from uwsim.missions.run import made, steps_of


class SavingClock:
    """Clock that records, after every wait, the state the mission would save and a copy of the vehicle."""

    def __init__(self, vehicle: ScriptedVehicle) -> None:
        self.vehicle = vehicle
        self.mission: ResumableMission | None = None
        self.saved: list[tuple[str, ScriptedVehicle]] = []

    @property
    def time_s(self) -> float:
        return self.vehicle.time_s

    def wait(self, duration_s: float) -> None:
        self.vehicle.wait(duration_s)
        self.saved.append((json.dumps(self.mission.save()), copy.deepcopy(self.vehicle)))


@pytest.mark.parametrize(
    ("beams_m", "legs"), [(50.0, {"approach", "turn", "abreast", "mow"}), (6.9, {"approach", "turn", "abreast"})]
)
def test_a_mission_resumed_at_any_moment_flies_the_same_path(beams_m: float, legs: set[str]) -> None:
    vehicle = ScriptedVehicle(beams_m=beams_m)
    clock = SavingClock(vehicle)
    clock.mission = AdaptiveLawnMower(vehicle, clock, PLAN)
    ended = clock.mission.run()
    assert len(clock.saved) > 100
    leg_at = [json.loads(text)["mower"]["leg"] for text, _ in clock.saved]
    changes = [k for k, (leg, following) in enumerate(pairwise(leg_at)) if leg != following]
    chosen = sorted({*changes[:6], *range(0, len(leg_at), 150)})
    for text, then in (clock.saved[k] for k in chosen):
        again = AdaptiveLawnMower(then, then, PLAN)
        again.restore(json.loads(text))
        assert again.run() == ended
        assert then.time_s == vehicle.time_s
        np.testing.assert_array_equal(then.position, vehicle.position)
    assert {leg_at[k] for k in chosen} == legs


def test_a_simulated_mission_resumes_to_the_last_bit() -> None:
    """Covers obstacle memory, autopilot and sensor noise."""
    plan = LawnMowerPlan(area_m=[[-104, -80], [56, -80], [56, 24], [-104, 24]])
    lake = partial(Simulator, "lake", mission_time_s=50.0)
    mission = mow_twice(lake, plan, lambda mission, sim: sim.time_s > 35.0)
    assert len(mission.lookout.obstacles.peaks_world_m) > 10


def test_remembered_obstacles_are_saved_the_oldest_first() -> None:
    memory = ObstacleMemory(pings=3)
    for height in range(5):
        memory._ring[memory._seen % 3] = height
        memory._seen += 1
    np.testing.assert_array_equal(memory.peaks_world_m[:, 2], [2, 3, 4])
    other = ObstacleMemory(pings=3)
    other.restore(memory.peaks_world_m)
    np.testing.assert_array_equal(other.peaks_world_m, memory.peaks_world_m)


class Zigzag:
    """A user-defined mission that flies as many legs as its state says are left."""

    def __init__(self, vehicle: OwnVehicle, legs: int = 5) -> None:
        self.vehicle, self.left = vehicle, legs

    def steps(self) -> Steps[str]:
        while self.left:
            self.vehicle.set_effort(surge=0.5, yaw=0.3 if self.left % 2 else -0.3)
            self.left -= 1
            yield wait(1.0)
        return "all legs are flown"

    def save(self) -> dict[str, int]:
        return {"left": self.left}

    def restore(self, state: dict[str, int]) -> None:
        self.left = state["left"]


def test_a_mission_of_ones_own_with_steps_and_a_state_resumes_at_any_moment() -> None:
    mission = partial(Zigzag, legs=7)
    vehicle = ScriptedVehicle()
    clock = SavingClock(vehicle)
    (clock.mission,) = made(mission, {"rov": OwnVehicle(vehicle, clock)})
    assert isinstance(clock.mission, ResumableMission)
    assert drive(steps_of([clock.mission]), clock) == "all legs are flown"
    assert len(clock.saved) >= 5
    for text, then in clock.saved:
        (again,) = made(mission, {"rov": OwnVehicle(then, then)})
        again.restore(json.loads(text))
        assert drive(steps_of([again]), then) == "all legs are flown"
        assert then.time_s == vehicle.time_s
        np.testing.assert_array_equal(then.position, vehicle.position)


def test_a_class_of_steps_flies_as_a_function_does() -> None:
    def zigzag(vehicle: OwnVehicle) -> Steps[str]:
        return (yield from Zigzag(vehicle).steps())

    places = []
    for mission in (Zigzag, zigzag):
        vehicle = ScriptedVehicle()
        assert run(mission, vehicle, vehicle) == "all legs are flown"
        places.append(vehicle.position)
    np.testing.assert_array_equal(*places)


def test_a_function_and_a_mission_without_save_are_not_resumable() -> None:
    class Plain:
        progress = 0.0

        def run(self) -> str:
            return "done"

    def function(vehicle: OwnVehicle) -> Steps[None]:
        yield wait(1.0)

    assert not isinstance(Plain(), ResumableMission)
    vehicle = ScriptedVehicle()
    (one,) = made(function, {"rov": OwnVehicle(vehicle, vehicle)})
    assert not isinstance(one, ResumableMission)
    assert isinstance(AdaptiveLawnMower(vehicle, vehicle, PLAN), ResumableMission)


@pytest.mark.parametrize(
    ("field", "value", "complaint"),
    [
        ("leg", "dive", "mower.leg"),
        ("lane", -1, "mower.lane"),
        ("along_m", "far", "mower.along_m"),
        ("along_m", float("nan"), "mower.along_m"),
        ("unknown", 1, "mower.unknown"),
    ],
)
def test_an_invalid_state_is_refused(field: str, value: object, complaint: str) -> None:
    mission = AdaptiveLawnMower(ScriptedVehicle(), ScriptedVehicle(), PLAN)
    state = mission.save()
    state["mower"][field] = value
    with pytest.raises(ValueError, match=f"mission state: {complaint}: "):
        mission.restore(state)
    with pytest.raises(ValueError, match="mission state: mower: Field required"):
        mission.restore({})
