"""A mission restored from a saved state flies on as if nothing had happened."""

import copy
import json

import numpy as np
import pytest

from test_missions import PLAN, ScriptedVehicle
from uwsim import Simulator
from uwsim.missions import AdaptiveLawnMower, LawnMowerPlan, Mission, ObstacleMemory, ResumableMission


class SavingClock:
    """Keeps, at the end of every wait, the state that the mission would save and a copy of the vehicle."""

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
    seen = set()
    for text, then in clock.saved[::7]:
        seen.add(json.loads(text)["mower"]["leg"])
        again = AdaptiveLawnMower(then, then, PLAN)
        again.restore(json.loads(text))
        assert again.run() == ended
        assert then.time_s == vehicle.time_s
        np.testing.assert_array_equal(then.position, vehicle.position)
    assert seen == legs


def test_a_simulated_mission_resumes_to_the_last_bit() -> None:
    """Obstacle memory, autopilot and sensor noise included, during undocking and after it."""
    plan = LawnMowerPlan(area_m=[[-104, -80], [56, -80], [56, 24], [-104, 24]])
    sim = Simulator("lake", mission_time_s=120.0)
    saved: list[tuple[str, bytes]] = []

    class Clock:
        time_s = property(lambda self: sim.time_s)

        def wait(self, duration_s: float) -> None:
            sim.wait(duration_s)
            saved.append((json.dumps(mission.save()), sim.save_state()))

    mission = AdaptiveLawnMower(sim.rov, Clock(), plan)
    assert mission.run() == "the battery is used up"
    expected = sim.save_state()
    assert len(mission.obstacles_ahead.peaks_world_m) > 10
    for k in (20, 500, 1180):
        fresh = Simulator("lake", mission_time_s=120.0)
        again = AdaptiveLawnMower(fresh.rov, fresh, plan)
        again.restore(json.loads(saved[k][0]))
        fresh.restore_state(saved[k][1])
        again.run()
        assert fresh.save_state() == expected, k


def test_remembered_obstacles_are_saved_the_oldest_first() -> None:
    memory = ObstacleMemory(pings=3)
    for height in range(5):
        memory._ring[memory._seen % 3] = height
        memory._seen += 1
    np.testing.assert_array_equal(memory.peaks_world_m[:, 2], [2, 3, 4])
    other = ObstacleMemory(pings=3)
    other.restore(memory.peaks_world_m)
    np.testing.assert_array_equal(other.peaks_world_m, memory.peaks_world_m)


def test_a_mission_without_save_is_not_resumable() -> None:
    class Plain:
        progress = 0.0

        def run(self) -> str:
            return "done"

    mission: Mission = Plain()
    assert not isinstance(mission, ResumableMission)
    assert isinstance(AdaptiveLawnMower(ScriptedVehicle(), ScriptedVehicle(), PLAN), ResumableMission)


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
