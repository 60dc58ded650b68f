"""The examples' missions flown with faults: each outcome is the one stated in docs/guides/faults.md."""

import numpy as np
import pytest

import uwsim
from uwsim import Simulator
from uwsim.bridges import RosbridgeServer
from uwsim.bridges.remote.flight import fly_remote
from uwsim.examples import (
    m01_hello_dive,
    m02_ping_and_plot,
    m03_lawn_mower,
    m04_into_the_unknown,
    m05_pipeline_inspection,
    m06_gates,
    m07_wall_scan,
    m08_station_keeping,
    m09_two_vehicles,
    m10_digital_twin,
    m11_over_rosbridge,
)
from uwsim.live import LiveSimulator
from uwsim.missions.planners import pipeline
from uwsim.scenario import Scenario, load
from uwsim.scenario.build.station import exit_position
from uwsim.simulator.helm import FailsafeWarning


def scenario_of(name: str, *faults: dict, **failsafe: object) -> Scenario:
    base = load(name)
    plain = {key: getattr(base, key) for key in type(base).model_fields}
    vehicles = [{**dict(entry), "failsafe": failsafe or None} for entry in base.vehicles]
    return Scenario.model_validate({**plain, "vehicles": vehicles, "faults": list(faults)})


def times(sim: Simulator) -> dict[str, float]:
    """Return the times at which each fault and the failsafe began."""
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
    assert depths_m[-1] < sound[len(depths_m) - 1] - 0.3  # this vehicle climbs, the sound one dives
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


SAG = {"kind": "battery", "thrust": 0.7, "at_s": 10.0}
WEAK = {"kind": "thruster", "axis": "surge", "health": 0.6, "at_s": 20.0}
NO_DVL = {"kind": "sensor", "sensor": "dvl", "mode": "off", "at_s": 15.0}
CURRENT = {"kind": "current", "velocity_world_m_s": [0.1, 0.05, 0.0], "at_s": 20.0}
LEAK = {"kind": "leak", "kg_per_s": 0.2, "kg_max": 1.0, "at_s": 12.0}


def began(sim: Simulator) -> list[str]:
    return sorted(event.values["fault"] for event in sim.events if event.name == "fault")


def test_the_pings_end_at_the_surface_when_the_altimeter_falls_silent_with_the_battery_sagging():
    silent = {"kind": "sensor", "sensor": "altitude", "mode": "off", "at_s": 12.0}
    sim = Simulator(scenario_of("lake", SAG, silent, sensor_then="surface", ascent_m_s=0.5, surface_m=1.0), seed=3)
    with pytest.warns(FailsafeWarning, match="surface: sensor"):
        uwsim.fly(m02_ping_and_plot.mission, sim, time_limit_s=30.0)
    assert began(sim) == ["battery", "sensor"]
    sim.advance(45.0)
    assert sim.rov.pose.position_world_m[2] == pytest.approx(-1.0, abs=0.1)


def test_unknown_water_is_mown_with_weak_thrust_and_a_current():
    sim = Simulator(scenario_of("cove", WEAK, CURRENT), seed=3)
    flown = uwsim.fly(m04_into_the_unknown.mission, sim, arguments={"bound_m": 11.0})
    assert not flown.ended_early and flown.collisions == 0 and began(sim) == ["current", "thruster"]
    assert flown.result.flown_m2 > 150.0


def test_the_pipeline_is_inspected_without_a_dvl_in_a_current(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(pipeline, "LOOK_PIXELS", 80)
    sim = Simulator(scenario_of("cove", NO_DVL, CURRENT), seed=3)
    flown = uwsim.fly(m05_pipeline_inspection.mission, sim)
    assert not flown.ended_early and flown.collisions == 0 and began(sim) == ["current", "sensor"]
    assert flown.result.length_m > 25.0
    assert np.linalg.norm(flown.result.crossings_m[-1] - (16.0, -10.0)) < 1.0, "the pipe's end"


def test_the_gate_is_passed_both_ways_with_weak_thrust_in_a_current():
    sim = Simulator(scenario_of("cove", WEAK, CURRENT), seed=3)
    flown = uwsim.fly(m06_gates.mission, sim)
    assert not flown.ended_early and flown.collisions == 0 and began(sim) == ["current", "thruster"]
    assert flown.result == pytest.approx([4.0, 4.0], abs=0.3)


def test_the_wall_is_scanned_at_its_distance_with_water_aboard_and_weak_thrust():
    base = scenario_of("pool", LEAK, WEAK)
    plain = {key: getattr(base, key) for key in type(base).model_fields}
    wall = {"kind": "box", "name": "wall", "position_m": [7, 0, -2.5], "size_m": [1, 14, 5]}
    sim = Simulator(Scenario.model_validate({**plain, "obstacles": [wall]}), seed=3)
    flown = uwsim.fly(m07_wall_scan.mission, sim)
    assert not flown.ended_early and flown.collisions == 0 and began(sim) == ["leak", "thruster"]
    assert flown.result == pytest.approx([m07_wall_scan.DISTANCE_M] * len(flown.result), abs=0.3)


def test_a_place_is_kept_by_the_estimate_with_a_thruster_out_and_a_dvl_that_drops_out():
    out = {"kind": "thruster", "thruster": None, "health": 0.0, "at_s": 30.0, "vehicle": "scout"}
    out["thruster"] = next(iter(Simulator("pair").vehicles["scout"].thrusters))
    dropped = {**NO_DVL, "at_s": 40.0, "for_s": 10.0, "vehicle": "scout"}
    sim = Simulator(scenario_of("pair", out, dropped), seed=3)
    flown = uwsim.fly(m08_station_keeping.mission, sim, vehicles=["scout"], estimate="filter")
    assert not flown.ended_early and began(sim) == ["sensor", "thruster"]
    off_m = np.linalg.norm(flown.samples["scout"].path_world_m - m08_station_keeping.PLACE_M, axis=1)
    assert off_m[-50:].max() < 1.0


def test_one_of_two_vehicles_surfaces_with_a_leak_while_the_other_holds_without_its_altimeter():
    leak = {**LEAK, "at_s": 20.0, "vehicle": "scout"}
    silent = {"kind": "sensor", "sensor": "altitude", "mode": "off", "at_s": 25.0, "vehicle": "rov"}
    sim = Simulator(scenario_of("pair", leak, silent, leak_then="surface", sensor_then="hold"), seed=3)
    with pytest.warns(FailsafeWarning):
        uwsim.fly(m09_two_vehicles.mission, sim, time_limit_s=35.0)
    assert [sim.vehicles[name].failsafe.state for name in ("scout", "rov")] == ["surface", "hold"]
    before_m = sim.rov.pose.position_world_m
    sim.advance(30.0)
    assert np.linalg.norm(sim.rov.pose.position_world_m - before_m) < 0.7, "it had way on"
    assert sim.vehicles["scout"].pose.position_world_m[2] == pytest.approx(-0.5, abs=0.2)


def test_the_twin_is_given_up_for_home_when_water_comes_in_with_the_battery_sagging():
    sim = Simulator(scenario_of("cove", SAG, {**LEAK, "at_s": 40.0}, leak_then="return", height_m=1.5), seed=3)
    with pytest.warns(FailsafeWarning, match="return: leak"):
        flown = uwsim.fly(m10_digital_twin.mission, sim, time_limit_s=120.0)
    home_m = exit_position(sim.scenario.station)
    assert began(sim) == ["battery", "leak"] and flown.collisions == 0
    assert sim.rov.failsafe.state == "return"
    assert np.linalg.norm(sim.rov.pose.position_world_m[:2] - home_m[:2]) < 0.7


@pytest.mark.filterwarnings("ignore::uwsim.simulator.helm.FailsafeWarning")
def test_a_vehicle_behind_a_rosbridge_surfaces_with_a_leak_and_a_sagging_battery():
    sag, leak = {**SAG, "at_s": 2.0}, {**LEAK, "at_s": 3.0}
    scenario = scenario_of("pool", sag, leak, leak_then="surface", surface_m=1.0)
    with LiveSimulator(Simulator(scenario, seed=3), paused=True) as live, RosbridgeServer(live) as server:
        fly_remote(m11_over_rosbridge.mission, server.url, lockstep=True, time_limit_s=8.0)
        sim = live.simulator
        live.step(round(30.0 / sim.step_s))
        assert began(sim) == ["battery", "leak"]
        assert sim.rov.failsafe.state == "surface"
        assert sim.rov.pose.position_world_m[2] == pytest.approx(-1.0, abs=0.2)
