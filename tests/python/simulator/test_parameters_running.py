"""Parameters of a running simulator: errors, atomic changes, reset, saved states, the live log and its replay."""

from __future__ import annotations

import math
from typing import Any

import pytest

from parameter_world import observed, world
from uwsim import Scenario, Simulator
from uwsim.channels import channels
from uwsim.simulator.parameters import UnknownParameterError

CHANGES: dict[str, Any] = {
    "rov.mass_kg": 720.0,
    "rov.centre_of_buoyancy_m.z": 0.15,
    "rov.sensors.imu.latency_s": 0.06,
    "rov.sensors.dvl.rate_hz": 20.0,
    "rov.sonar.mode": "physics",
    "auv.thrusters.left.health": 0.2,
    "auv.thrusters.right.gain": 2.0,
    "water.surface": {"kind": "airy", "amplitude_m": 0.5, "period_s": 4.0},
    "optics.jerlov": "5C",
}


@pytest.fixture(scope="module")
def made() -> Simulator:
    return Simulator(Scenario(**world()), threads=1)


@pytest.fixture
def sim(made: Simulator) -> Simulator:
    made.reset()
    return made


def rest_of(sim: Simulator) -> dict[str, bytes]:
    return observed(sim, pictures=True, imaging=False)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("rov.drag.linear.surge", -1, r"rov\.drag\.linear\.surge = -1 N s/m: must be in \[0, 1000000\] N s/m"),
        ("rov.mass_kg", "much", r"rov\.mass_kg = 'much': must be a number"),
        ("rov.mass_kg", math.nan, r"rov\.mass_kg = nan kg: must be in"),
        ("rov.sensors.altitude.range_max_m", 1e9, r"rov\.sensors\.altitude\.range_max_m = 1000000000 m: must be in"),
        ("rov.sensors.imu.on", 1.5, r"rov\.sensors\.imu\.on = 1\.5: must be true or false"),
        ("optics.jerlov", "9D", r"optics\.jerlov = '9D': must be one of I, IA"),
        (
            "rov.drag.linear.srge",
            1,
            r"parameters\['rov\.drag\.linear\.srge'\]: .* did you mean 'rov\.drag\.linear\.surge'",
        ),
        ("step_s", 0.01, r"parameters\['step_s'\]: it is fixed when the simulator is made"),
        ("rov.sonar.tilt_deg", 10, r"it holds for the start; aim\(\) turns the head"),
        ("water.surface.amplitud_m", 1, r"water\.surface\.amplitud_m: unknown key; did you mean 'amplitude_m'"),
        ("water.surface", {"kind": "airy", "period_s": 3}, r"water\.surface\.amplitude_m: missing"),
        ("auv.fins", {"tail": {"area_m2": -1}}, r"auv\.fins\.tail\.area_m2 = -1 m2: must be in"),
        ("rov.lamps.front.on", "yes", r"rov\.lamps\.front\.on = 'yes': must be true or false"),
        ("rov.sonar.bending", True, "is for `mode: physics` only"),
        ("rov.sonar.rays_per_beam", 5, "has no effect: it is for `mode: physics` only"),
        ("rov.centre_of_mass_m.x", 5.0, "must be in the hull's bounding box"),
    ],
)
def test_a_mistake_is_named_and_changes_nothing(sim: Simulator, name: str, value: Any, message: str) -> None:
    before = sim.save_state()
    with pytest.raises(ValueError, match=message):
        sim.parameters.update({"rov.friction": 0.9, name: value})
    assert sim.parameters["rov.friction"] == 0.5
    assert sim.save_state() == before


def test_an_unknown_name_is_a_key_error_too(sim: Simulator) -> None:
    assert "rov.drag" in sim.parameters and "rov.dragg" not in sim.parameters
    with pytest.raises(KeyError):
        sim.parameters["rov.dragg"]
    with pytest.raises(UnknownParameterError, match=r"has several values, such as rov\.drag\.linear\.surge"):
        sim.parameters.describe("rov.drag")


def test_what_is_described_is_what_the_scenario_says(sim: Simulator) -> None:
    sim.parameters["rov.drag.linear.surge"] = 40
    drag = sim.parameters.describe("rov.drag.linear.surge")
    assert (drag.value, drag.default, drag.unit, drag.low, drag.high) == (40.0, 30.0, "N s/m", 0, 1e6)
    assert drag.key == "vehicles[0].model.linear_damping[0]"
    assert sim.parameters.scenario.vehicles[0].model.linear_damping == (40.0, 40.0, 50.0, 6.0, 7.0, 8.0)
    noise = sim.parameters.describe("rov.sensors.imu.channels.angular_velocity.density")
    assert (noise.unit, noise.type) == ("rad/s/sqrt(Hz)", "number")
    assert sim.parameters["rov.drag.linear"] == [40.0, 40.0, 50.0, 6.0, 7.0, 8.0]
    assert [name for name in sim.parameters if not sim.parameters.describe(name).description] == []


def test_what_is_changed_and_reset_within_a_step_leaves_no_trace(sim: Simulator) -> None:
    sim.rov.set_effort(surge=0.5)
    sim.step(13)
    state = sim.save_state()
    untouched = rest_of(sim)
    sim.restore_state(state)
    sim.parameters.update(CHANGES)
    sim.parameters.reset()
    assert sim.parameters.changes == {}
    assert rest_of(sim) == untouched


def test_what_was_set_whole_is_reset_whole(sim: Simulator) -> None:
    waves = {"kind": "jonswap", "significant_height_m": 0.5, "peak_period_s": 4.0}
    sim.parameters["water.surface"] = waves
    sim.parameters["water.surface.significant_height_m"] = 0.8
    assert sim.parameters["water.surface"]["significant_height_m"] == 0.8
    sim.parameters.reset("water.surface.significant_height_m")
    assert sim.parameters["water.surface.significant_height_m"] == 0.5
    with pytest.raises(ValueError, match=r"was set with water\.surface: reset that instead"):
        sim.parameters.reset("water.surface.peak_period_s")
    sim.parameters.reset("water.surface")
    assert sim.parameters["water.surface.amplitude_m"] == 0.3
    sim.parameters.update(
        {"water.current": {"kind": "tidal", "amplitude_m_s": [0.1, 0, 0]}, "water.current.0.phase_deg": 5}
    )
    assert sim.parameters["water.current.0.phase_deg"] == 5 and len(sim.parameters["water.current"]) == 1


def test_a_change_keeps_motion_and_acts_from_the_next_step_on(sim: Simulator) -> None:
    sim.parameters.update(
        {"water.current": [], "water.current_world_m_s": [0, 0, 0], "water.surface": {"kind": "still"}}
    )
    sim.rov.place((2, 0, -3), velocity_body=(1, 0, 0, 0, 0, 0))
    sim.step(3)
    before = sim.rov.pose.position_world_m, sim.rov.velocity.linear_body_m_s
    sim.parameters["rov.drag.linear.surge"] = 1e5
    assert (sim.rov.pose.position_world_m == before[0]).all() and (sim.rov.velocity.linear_body_m_s == before[1]).all()
    sim.step(100)
    assert abs(sim.rov.velocity.linear_body_m_s[0]) < 0.5 * before[1][0]


def test_states_hold_changes(sim: Simulator) -> None:
    sim.parameters.update(CHANGES)
    sim.parameters["rov.lamps.front.on"] = False
    sim.step(17)
    state = sim.save_state()
    future = rest_of(sim)
    other = Simulator(Scenario(**world()), threads=1)
    other.parameters["rov.friction"] = 0.9
    other.restore_state(state)
    assert other.parameters.changes == sim.parameters.changes
    assert other.parameters["rov.friction"] == 0.5 and not other.rov.lamps["front"].on
    assert rest_of(other) == future
    other.parameters.reset("rov")
    assert other.parameters["rov.mass_kg"] == 690.0 and other.parameters["optics.jerlov"] == "5C"
    assert other.rov.lamps["front"].on


def test_a_fault_is_unknown_to_the_allocation_and_a_gain_is_not(sim: Simulator) -> None:
    auv = sim.vehicles["auv"]
    full = auv.full_wrench_body[0][0]
    sim.parameters["mission_time_s"] = 100.0
    auv.release()
    auv.set_effort(surge=1.0)
    sim.parameters["auv.thrusters.left.health"] = 0.0
    assert auv.full_wrench_body[0][0] == full
    sim.step(400)
    assert auv.thrusters["left"].command == 1.0 and auv.thrusters["left"].thrust_n == 0.0
    single_n = auv.thrusters["right"].thrust_n
    sim.parameters["auv.thrusters.right.gain"] = 2.0
    sim.parameters["auv.thrusters.left.gain"] = 2.0
    assert auv.full_wrench_body[0][0] == pytest.approx(2 * full)
    sim.step(400)
    assert auv.thrusters["right"].thrust_n > 1.7 * single_n, "the held effort is allocated anew; the battery sags"


def test_ballast_is_a_second_body(sim: Simulator) -> None:
    craft = sim.parameters.scenario.vehicles[0].model
    assert craft.ballast_kg == 5.0
    sim.parameters.update(
        {"water.current": [], "water.current_world_m_s": [0, 0, 0], "water.surface": {"kind": "still"}}
    )
    lighter = Simulator(sim.parameters.scenario.model_copy(update={}), threads=1)
    for each, extra_kg in ((sim, 0.0), (lighter, 20.0)):
        each.parameters["rov.ballast_kg"] = 5.0 + extra_kg
        each.rov.place((2, 0, -3))
        each.step()
    difference = lighter.rov.velocity.linear_body_m_s[2] - sim.rov.velocity.linear_body_m_s[2]
    assert difference < 0, "what is heavier sinks faster"


def test_a_sensor_that_is_off_reads_nothing(sim: Simulator) -> None:
    sim.step(20)
    sim.parameters["rov.sensors.depth.on"] = False
    sim.step(20)
    sample = sim.rov.sensors["depth"].sample()
    assert math.isnan(sample.value) and not sample.valid
    assert math.isnan(sim.rov.sensors["imu"].read().linear_acceleration_m_s2[0]) is False
    sim.parameters["rov.sensors.depth.on"] = True
    assert math.isfinite(sim.rov.sensors["depth"].read())


def test_set_optics_is_one_way_to_set_parameters(sim: Simulator) -> None:
    sim.set_optics(jerlov="II", sun_elevation_deg=20)
    assert sim.parameters.changes == {"optics.jerlov": "II", "optics.sun_elevation_deg": 20}
    assert sim.optics.jerlov == "II"


def test_channels_follow_the_parameters() -> None:
    sim = Simulator("pool", threads=1)
    table = {channel.name: channel for channel in channels(sim)}

    def read(name: str) -> Any:
        sim.step(20)
        return table[name].read(sim)

    assert len(read("scan").ranges) == 513 and read("modelTrigger").data == "2"
    assert read("altitude").max_range == sim.parameters["rov.sensors.altitude.range_max_m"]
    changes = {"rov.sonar.model": 3, "rov.sensors.altitude.range_max_m": 7.0, "rov.sensors.depth.on": False}
    sim.parameters.update(changes)
    assert len(read("scan").ranges) == 1025 and read("modelTrigger").data == "3"
    assert read("depthArray").data.count("a") == 1025
    assert read("altitude").max_range == 7.0
    assert read("depth") is None
    sim.parameters.update({"rov.sonar.model": "em2040-07", "rov.sonar.frequency_hz": 400000.0})
    assert len(read("scan").ranges) == 400
    assert read("depthArray") is None and read("modelTrigger") is None
