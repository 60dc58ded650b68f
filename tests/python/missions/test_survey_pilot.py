"""The lawn-mower steers a vehicle by the model of its thrusters, and one without thrusters by the plain autopilot."""

import json
from pathlib import Path

import pytest

from test_missions import ScriptedVehicle
from uwsim import Simulator
from uwsim.missions import AdaptiveLawnMower, LawnMowerPlan
from uwsim.missions.survey_pilot import memory_of, remember, survey_pilot
from uwsim.navigation.control.autopilot import Autopilot
from uwsim.navigation.control.controller import Controller
from uwsim.scenario.read.assets import assets_folder

PLAN = LawnMowerPlan([[-40, -10], [40, -10], [40, 10], [-40, 10]], altitude_m=2.0, speed_m_s=1.4)


def wide_pool(folder: Path, model: str, seconds: float = 60.0) -> Simulator:
    text = (assets_folder() / "scenarios" / "pool.yaml").read_text()
    text = text.replace("size_m: [20, 20]", "size_m: [100, 100]").replace("model: rov", f"model: {model}")
    path = folder / f"{model}.yaml"
    path.write_text(text)
    sim = Simulator(path, mission_time_s=seconds)
    sim.rov.release()
    sim.rov.place([-42.0, -12.0, -2.5])
    return sim


def test_thrusters_are_steered_by_their_model(tmp_path: Path) -> None:
    assert isinstance(survey_pilot(wide_pool(tmp_path, "bluerov2_heavy").rov, 0.1), Controller)
    assert isinstance(survey_pilot(wide_pool(tmp_path, "rov").rov, 0.1), Autopilot)
    assert isinstance(survey_pilot(ScriptedVehicle(), 0.1), Autopilot), "a remote vehicle tells no model"


def test_a_heavy_vehicle_stays_level_at_full_speed_and_resumes_to_the_last_bit(tmp_path: Path) -> None:
    sim = wide_pool(tmp_path, "bluerov2_heavy")
    upright, saved = [], []

    class Clock:
        time_s = property(lambda self: sim.time_s)

        def wait(self, duration_s: float) -> None:
            sim.wait(duration_s)
            upright.append(sim.rov.pose.world_from_body[2, 2])
            if len(upright) == 300:
                saved.append((json.dumps(mission.save()), sim.save_state()))

    mission = AdaptiveLawnMower(sim.rov, Clock(), PLAN)
    assert mission.run() == "the battery is used up"
    assert min(upright) > 0.9, "25 degrees"
    again_sim = wide_pool(tmp_path, "bluerov2_heavy")
    again = AdaptiveLawnMower(again_sim.rov, again_sim, PLAN)
    again.restore(json.loads(saved[0][0]))
    again_sim.restore_state(saved[0][1])
    again.run()
    assert again_sim.save_state() == sim.save_state()


def test_what_another_kind_of_pilot_remembers_is_refused(tmp_path: Path) -> None:
    pilot = survey_pilot(wide_pool(tmp_path, "bluerov2_heavy").rov, 0.1)
    assert len(memory_of(pilot)) == 25
    with pytest.raises(ValueError, match="3 numbers: this vehicle's pilot has 25"):
        remember(pilot, (0.0, 0.0, 0.0))
