"""Vehicles that cannot go sideways fly a survey: a torpedo with fins, one with three thrusters, and a heavy box."""

from pathlib import Path

import pytest
import yaml

import uwsim
from uwsim import Simulator
from uwsim.flight.flyable_lanes import survey_plan
from uwsim.flight.terminal import Silent
from uwsim.missions import AdaptiveLawnMower
from uwsim.missions.lawn_mower import COVERED
from uwsim.scenario.read.assets import find_yaml
from vehicle_files import vehicle_file

AREAS = {
    "lagoon": [[-12, -6], [12, -6], [12, 6], [-12, 6]],
    "lake": [[-30, -10], [30, -10], [30, 10], [-30, 10]],
}
T200 = {"model": "t200_16v"}
THREE_THRUSTERS = {
    "port": T200 | {"position_m": [-0.1, 0.11, 0.0], "axis": [1, 0, 0]},
    "starboard": T200 | {"position_m": [-0.1, -0.11, 0.0], "axis": [1, 0, 0]},
    "vertical": T200 | {"position_m": [0.0, 0.0, 0.0], "axis": [0, 0, 1]},
}


BLUNT = {
    "size_m": (2.0, 1.2, 1.2),
    "added_mass": [400, 900, 1500, 100, 300, 200],
    "linear_damping": [50, 100, 200, 500, 800, 400],
    "quadratic_damping": [500, 1000, 2000, 300, 600, 500],
    "max_force_n": [1200, 0, 1200],
    "max_torque_nm": [0, 0, 400],
    "sonar": {"position_m": [0.9, 0.0, -0.6]},
    "sensors": {"altitude": {"kind": "altitude", "position_m": [0.0, 0.0, -0.6], "range_max_m": 100}},
}
"""A box of 2.9 t: its slip takes some 10 s to die down, in which it goes as many metres."""


def packaged(name: str, folder: str) -> dict:
    return yaml.safe_load(find_yaml(name, folder).read_text())


def written(folder: Path, place: str, vehicle: str, speed_m_s: float, current_m_s=(0.0, 0.0, 0.0)) -> Path:
    """Write a packaged scenario with a vehicle that cannot go sideways."""
    model: str | dict = "lauv" if vehicle == "lauv" else "remus100"
    if vehicle == "three thrusters":
        model = packaged("bluerov2_heavy", "vehicles") | {"thrusters": THREE_THRUSTERS}
        model["control"] = {axis: model["control"][axis] for axis in ("surge", "heave", "yaw")}
        (folder / "three.yaml").write_text(yaml.safe_dump(model))
        model = "three.yaml"
    if vehicle == "blunt":
        model = vehicle_file(folder, **BLUNT).name
    scenario = packaged(place, "scenarios")
    scenario["vehicles"][0]["model"] = model
    scenario["survey"]["speed_m_s"] = speed_m_s
    if place in AREAS:
        scenario["survey"]["area_m"] = AREAS[place]
    scenario["water"]["current_world_m_s"] = list(current_m_s)
    path = folder / f"{place}.yaml"
    path.write_text(yaml.safe_dump(scenario))
    return path


@pytest.mark.parametrize(
    ("place", "vehicle", "speed_m_s", "current_m_s"),
    [("lagoon", "remus100", 1.2, (0.25, 0.3, 0.0)), ("pool", "three thrusters", 0.4, (0.1, 0.12, 0.0))],
)
def test_it_covers_the_bed_in_a_current_and_touches_nothing(tmp_path, place, vehicle, speed_m_s, current_m_s):
    scenario = written(tmp_path, place, vehicle, speed_m_s, current_m_s)
    flown = uwsim.run_survey(scenario, tmp_path / "out", report="json", screen=Silent())
    assert not flown.ended_early and flown.result == COVERED
    assert flown.collisions == 0
    assert flown.coverage is not None and flown.coverage > 0.98


def test_a_blunt_hull_that_slips_in_a_curve_stops_for_its_turns(tmp_path):
    scenario = written(tmp_path, "lake", "blunt", 1.0, (0.1, 0.15, 0.0))
    flown = uwsim.run_survey(scenario, tmp_path / "out", report="json", screen=Silent())
    assert "stops_to_turn" in (tmp_path / "out" / "log.jsonl").read_text()
    assert not flown.ended_early and flown.result == COVERED
    assert flown.collisions == 0
    assert flown.coverage is not None and flown.coverage > 0.98


def test_a_torpedo_that_misses_its_curve_keeps_the_speed_at_which_its_fins_turn_it(tmp_path):
    path = written(tmp_path, "lake", "lauv", 0.8)
    with Simulator(path) as sim:
        mission = AdaptiveLawnMower(sim.rov, sim, survey_plan(sim.scenario.survey))
        assert mission.run() == COVERED
        assert mission.state.radius_m > 5.0  # its first curves, of 2.3 m, were too narrow for it
