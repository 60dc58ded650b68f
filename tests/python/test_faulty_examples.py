"""The examples' missions, flown with faults: each ends as docs/faults.md states."""

import numpy as np
import pytest

import uwsim
from uwsim import Simulator
from uwsim.command_gate import FailsafeWarning
from uwsim.examples import m01_hello_dive, m03_lawn_mower
from uwsim.scenario import Scenario, load
from uwsim.scenario.build.station import exit_position


def scenario_of(name: str, *faults: dict, **failsafe: object) -> Scenario:
    base = load(name)
    (entry,) = base.vehicles
    plain = {key: getattr(base, key) for key in type(base).model_fields}
    vehicles = [{**dict(entry), "failsafe": failsafe or None}]
    return Scenario.model_validate({**plain, "vehicles": vehicles, "faults": list(faults)})


def times(sim: Simulator) -> dict[str, float]:
    """When each fault began, and the failsafe."""
    return {
        event.values["fault"] if event.name == "fault" else event.name: event.time_s
        for event in sim.events
        if event.name in ("fault", "failsafe")
    }


def test_the_dive_ends_at_the_surface_when_water_comes_in_and_the_depth_sensor_sticks():
    leak = {"kind": "leak", "kg_per_s": 0.5, "kg_max": 1.0, "at_s": 3.0}
    stuck = {"kind": "sensor", "sensor": "depth", "mode": "stuck", "at_s": 5.0}
    sim = Simulator(scenario_of("lake", leak, stuck, leak_then="surface", ascent_m_s=0.25, surface_m=1.0), seed=3)
    with pytest.warns(FailsafeWarning, match="surface: leak"):
        depths_m = uwsim.fly(m01_hello_dive.mission, sim, report="none", time_limit_s=8.0).samples["rov"]["depth_m"]
    sound = uwsim.fly(m01_hello_dive.mission, "lake", seed=3, report="none").samples["rov"]["depth_m"]
    assert sound.max() == pytest.approx(8.0, abs=0.3)
    assert depths_m[-1] < sound[len(depths_m) - 1] - 0.3  # by then it climbs, while the sound one still dives
    assert times(sim)["leak"] == 3.0 < times(sim)["failsafe"] < times(sim)["sensor"] == 5.0
    before_m, climbed_s = sim.rov.pose.position_world_m, 4.0
    sim.advance(climbed_s)
    assert sim.rov.pose.position_world_m[2] - before_m[2] == pytest.approx(0.25 * climbed_s, rel=0.2)
    sim.advance(60.0)
    assert sim.rov.pose.position_world_m[2] == pytest.approx(-1.0, abs=0.1)
    assert sim.rov.pose.position_world_m[:2] == pytest.approx(before_m[:2], abs=0.5)
    assert (sim.rov.failsafe.state, sim.rov.failsafe.cause) == ("surface", "leak")


def test_the_survey_ends_at_home_when_water_comes_in_with_the_battery_sagging():
    sag, leak = (
        {"kind": "battery", "thrust": 0.7, "at_s": 10.0},
        {"kind": "leak", "kg_per_s": 0.2, "at_s": 30.0, "for_s": 5.0},
    )
    sim = Simulator(scenario_of("pool", sag, leak, leak_then="return", height_m=1.0), seed=3)
    with pytest.warns(FailsafeWarning, match="return: leak"):
        flown = uwsim.fly(m03_lawn_mower.mission, sim, report="none", time_limit_s=100.0)
    assert not any(event.name == "mown" for event in flown.events)
    path_m, seconds = flown.samples["rov"].path_world_m, flown.samples["rov"]["time_s"]
    home_m = exit_position(sim.scenario.station)
    away_m = np.linalg.norm(path_m[:, :2] - home_m[:2], axis=1)
    assert away_m[seconds < 30.0].max() > 2.0
    assert away_m[-1] < 0.5
    assert sim.rov.collisions == 0
    assert times(sim)["battery"] == 10.0 < times(sim)["leak"] == 30.0 < times(sim)["failsafe"] < 32.0
    assert sim.faults.water_kg("rov") == pytest.approx(1.0)
    assert sim.rov.failsafe.state == "return"
