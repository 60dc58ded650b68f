"""Faults, random or injected, occur when and as specified, and act through the physics."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from sites import deep_lake
from sites import deep_lake as lake
from uwsim import Simulator
from uwsim.channels import Table, channels
from uwsim.channels.ros.messages import default_message
from uwsim.link import seen_channels
from uwsim.live import LiveSimulator
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.spec.fault import FAULTS

G = 9.80665


def bluerov(*faults, **options) -> Simulator:
    return Simulator(lake(*faults, model="bluerov2_heavy", **options), seed=3)


def names(sim):
    return [(event.name, event.values.get("fault"), event.time_s) for event in sim.events]


def test_a_fault_lasts_from_when_it_is_said_to_for_as_long_as_it_is_said_to():
    sim = bluerov({"kind": "thruster", "thruster": "front_left", "health": 0.3, "at_s": 1.0, "for_s": 2.0})
    health = "rov.thrusters.front_left.health"
    seen = []
    for _ in range(8):
        sim.advance(0.5)
        seen.append(sim.parameters[health])
    assert seen == [1.0, 1.0, 0.3, 0.3, 0.3, 0.3, 1.0, 1.0]  # takes effect in the step after its tick
    assert names(sim) == [("fault", "thruster", 1.0), ("fault_ends", "thruster", 3.0)]
    assert sim.parameters.changes == {}


def test_a_thruster_that_is_out_takes_its_share_of_the_wrench_away():
    sound, faulty = bluerov(), bluerov({"kind": "thruster", "thruster": "front_left", "at_s": 0.0})
    for sim in (sound, faulty):
        sim.rov.set_effort(surge=0.5)
        sim.advance(0.5)
    thrusts = {name: state.thrust_n for name, state in sound.rov.thrusters.items()}
    left = {name: state.thrust_n for name, state in faulty.rov.thrusters.items()}
    assert left == {**thrusts, "front_left": 0.0}
    mount = sound.scenario.vehicles[0].model.thrusters["front_left"]
    lost_nm = np.cross(mount.position_m, mount.axis)[2] * thrusts["front_left"]
    assert abs(sound.rov.velocity.angular_body_rad_s[2]) < 1e-6
    assert math.copysign(1, faulty.rov.velocity.angular_body_rad_s[2]) == math.copysign(1, -lost_nm)


def test_two_faults_of_one_thruster_multiply():
    weak = {"kind": "thruster", "thruster": "rear_left", "health": 0.5, "at_s": 0.0}
    sim = bluerov(weak, {"kind": "battery", "thrust": 0.6, "at_s": 0.0})
    sim.step()
    assert sim.parameters["rov.thrusters.rear_left.health"] == pytest.approx(0.3)
    assert sim.parameters["rov.thrusters.rear_right.health"] == pytest.approx(0.6)


def test_a_leak_adds_weight_as_stated_and_it_stays():
    sim = Simulator(lake({"kind": "leak", "kg_per_s": 0.2, "at_s": 2.0, "for_s": 10.0}))
    sim.advance(6.005)
    assert sim.faults.water_kg("rov") == pytest.approx(0.8)
    assert sim.parameters["rov.ballast_kg"] == pytest.approx(0.8)
    sim.advance(20.0)
    assert sim.faults.water_kg("rov") == pytest.approx(2.0)
    assert sim.faults.active == ()
    assert sim.parameters["rov.ballast_kg"] == pytest.approx(2.0)
    sim.faults.inject("leak", kg_per_s=1.0, kg_max=2.5)
    sim.advance(10.0)
    assert sim.faults.water_kg("rov") == pytest.approx(4.5), "no more than its compartment"


def test_buoyancy_is_lost_when_as_much_water_is_in_as_it_was_too_light():
    """The vehicle sinks once kg_per_s t > rho V - m, and settles where drag balances the excess weight."""
    spare_kg, kg_per_s = 20.0, 5.0
    sim = Simulator(lake())
    sim.parameters["rov.mass_kg"] = sim.parameters["rov.mass_kg"] - spare_kg
    craft_z = sim.rov.pose.position_world_m[2]
    sim.faults.inject("leak", kg_per_s=kg_per_s, kg_max=2.0 * spare_kg)
    sim.advance(spare_kg / kg_per_s)
    assert sim.rov.velocity.linear_body_m_s[2] > 0.0  # still rising
    assert sim.rov.pose.position_world_m[2] > craft_z
    sim.advance(11.0)
    linear, quadratic = sim.parameters["rov.drag.linear.heave"], sim.parameters["rov.drag.quadratic.heave"]
    excess_n = spare_kg * G
    sink_m_s = (-linear + math.sqrt(linear**2 + 4 * quadratic * excess_n)) / (2 * quadratic)
    assert sim.rov.velocity.linear_body_m_s[2] == pytest.approx(-sink_m_s, rel=0.03)


@pytest.mark.parametrize("mode", ["off", "stuck", "bias"])
def test_a_sensor_fails_in_its_way(mode):
    bias = {"bias": 1.5} if mode == "bias" else {}
    sim = Simulator(
        lake({"kind": "sensor", "sensor": "depth", "mode": mode, "at_s": 1.0, "for_s": 5.0, **bias}), seed=5
    )
    other = Simulator(lake(), seed=5)
    for each in (sim, other):
        each.rov.set_effort(heave=-0.5)
        each.advance(1.0)
    before = sim.rov.sensors["depth"].read()
    for each in (sim, other):
        each.advance(4.0)
    told, sound = sim.rov.sensors["depth"].read(), other.rov.sensors["depth"].read()
    if mode == "off":
        assert math.isnan(told)
    elif mode == "stuck":
        assert told == before != sound
    else:
        assert told == pytest.approx(sound + 1.5)
    assert sim.rov.sensors["depth"].read(noise=False) == other.rov.sensors["depth"].read(noise=False) or mode == "off"
    for each in (sim, other):
        each.advance(2.0)
    assert sim.rov.sensors["depth"].read() == other.rov.sensors["depth"].read()


def test_a_bias_of_one_quantity_leaves_the_others():
    sim = Simulator(lake({"kind": "sensor", "sensor": "imu", "mode": "bias", "field": "angular_velocity_rad_s",
                          "bias": 0.25, "at_s": 0.0}), seed=5)  # fmt: skip
    sound = Simulator(lake(), seed=5)
    sim.step(), sound.step()
    told, true = sim.rov.sensors["imu"].read(), sound.rov.sensors["imu"].read()
    assert told.angular_velocity_rad_s == pytest.approx(true.angular_velocity_rad_s + 0.25)
    assert told.orientation_xyzw.tolist() == true.orientation_xyzw.tolist()


def test_streams_tell_what_readings_do_from_the_fault_on_and_until_it_ends():
    sim = Simulator(lake(), seed=5)
    stream = sim.rov.sensors["depth"].stream()
    sim.rov.set_effort(heave=-0.5)
    sim.advance(1.0)
    name = sim.faults.inject("sensor", sensor="depth", mode="stuck")
    stuck = sim.rov.sensors["depth"].read()
    sim.advance(1.0)
    sim.faults.end(name)
    sim.advance(1.0)
    name = sim.faults.inject("sensor", sensor="depth")
    sim.advance(1.0)
    sim.faults.end(name)
    samples = stream.take()
    depths_m, second = samples.readings[:, 0], np.ceil(1e-9 * samples.stamps_ns).astype(int)
    assert (depths_m[second == 2] == stuck).all()
    assert (depths_m[second == 3] != stuck).all()
    assert samples.valid[second <= 3].all()
    assert not samples.valid[(second == 4)].any()


def test_a_current_is_added_and_taken_away():
    sim = Simulator(lake({"kind": "current", "velocity_world_m_s": [0.4, 0.0, 0.0], "at_s": 0.0, "for_s": 60.0}))
    sim.parameters["water.current_world_m_s"] = [0.1, 0.0, 0.0]
    sim.advance(60.0)
    assert sim.rov.velocity.linear_body_m_s[0] == pytest.approx(0.5, rel=0.1)  # drifts with the water
    sim.step()
    assert sim.parameters["water.current_world_m_s.x"] == pytest.approx(0.1)


def test_a_current_goes_on_from_a_saved_state_and_ends_with_a_reset():
    fault = {"kind": "current", "velocity_world_m_s": [0.1, 0.1, 0.0], "at_s": 0.1, "for_s": 1.0}
    sim, other = (Simulator(lake(fault), seed=9) for _ in range(2))
    sim.advance(0.5)
    other.restore_state(sim.save_state())
    for each in (sim, other):
        each.advance(1.0)
    assert other.save_state() == sim.save_state()
    assert list(other.events) == list(sim.events)
    other.reset()
    other.advance(1.5)
    assert other.save_state() == sim.save_state()


def test_a_link_that_is_down_carries_nothing_either_way():
    scenario = lake({"kind": "link", "at_s": 1.0, "for_s": 4.0}, failsafe={"silence_s": 2.0, "then": "hold"})
    with LiveSimulator(scenario, speed="max", paused=True) as live:
        said = {channel.name: channel for channel in channels(live.simulator)}
        key = said["key"]

        def tell(surge):
            message = default_message(key.type)
            message.position.x, message.orientation.w = surge, 0.0
            key.apply(live, message)
            live.read(lambda sim: None).result()

        tell(0.5)
        live.step(200)
        assert said["telemetry"].read(live.simulator) is not None
        assert said["link"].read(live.simulator).fault_loss == 0.0
        live.step(1)
        assert said["link"].read(live.simulator).fault_loss == 1.0
        tell(1.0)
        assert live.rov.effort[0] == 0.5
        assert said["telemetry"].read(live.simulator) is None
        live.step(400)
        assert live.simulator.rov.failsafe.state == "hold"
        live.step(400)
        tell(1.0)
        assert live.rov.effort[0] == 1.0
        assert live.simulator.rov.failsafe.state == ""


def test_a_link_fault_takes_packets_that_are_in_the_water_and_the_status_says_so():
    scenario = lake({"kind": "link", "at_s": 1.0, "for_s": 2.0}).with_changes(modem="ideal_acoustic")
    sim = Simulator(scenario)
    sim.rov.place((-60.0, -40.0, -12.0))
    status = {channel.name: channel for channel in seen_channels(sim, Table(sim))}["link"]
    delay_s = sim.link.reception("station", "rov").delay_s
    assert delay_s > 0.02
    sim.advance(1.0 - 0.01)
    assert sim.link.send("station", "rov", "t", b"in the water when it begins")
    assert status.read(sim).fault_loss == 0.0
    sim.advance(1.5)
    assert status.read(sim).fault_loss == 1.0
    state = sim.save_state()
    sim.advance(1.0)
    sim.restore_state(state)
    assert status.read(sim).fault_loss == 1.0, "it goes on"
    sim.advance(1.0)
    sim.link.send("station", "rov", "t", b"afterwards")
    sim.advance(1.0)
    assert [one.payload for one in sim.link.received("rov")] == [b"afterwards"]
    (counts,) = sim.link.counts()
    assert counts.lost["fault"] == 1
    assert status.read(sim).fault_loss == 0.0


def test_over_a_link_that_is_down_lamps_stay_as_they_are_and_cameras_do_not_turn():
    with LiveSimulator(lake(), speed="max", paused=True) as live:
        offered = {service.name: service for service in Table(live.simulator).services}
        heard = {channel.name: channel for channel in channels(live.simulator)}
        rov, message = live.simulator.rov, default_message("std_msgs/msg/Float64")
        message.data = 0.25

        def ask_for_both(on):
            heard["camera/front/cmd_pan"].apply(live, message)
            answer = offered["lights/front"].call(live, {"data": on})
            live.step(100)
            return answer["success"], rov.lamps["front"].on, rov.cameras["front"].aim_rad[0]

        was = rov.lamps["front"].on
        live.command("inject_fault", kind="link", name="cut").result()
        live.step(1)
        assert ask_for_both(not was) == (False, was, 0.0)
        live.command("end_fault", name="cut").result()
        live.step(1)
        success, on, pan_rad = ask_for_both(not was)
        assert (success, on) == (True, not was)
        assert pan_rad > 0.1


def begins(sim):
    return [event.tick for event in sim.events if event.name == "fault"]


def test_faults_by_chance_come_at_their_rate_and_follow_from_the_seed():
    rate_per_h, long_s, short_s = 36_000.0, 8.0, 2.0
    fault = {"kind": "sensor", "sensor": "depth", "rate_per_h": rate_per_h, "for_s": 0.01}
    runs = []
    for seed, duration_s in ((2, short_s), (1, short_s), (1, long_s)):
        sim = Simulator(lake(fault), seed=seed)
        sim.rov.place((-60.0, -40.0, -12.0))
        sim.advance(duration_s)
        runs.append(begins(sim))
    other, short, long = runs
    assert other and other != short == long[: len(short)]
    expected = rate_per_h / 3600.0 * long_s
    assert abs(len(long) - expected) < 4.0 * math.sqrt(expected)
    drawn = [event.values["drawn"] for event in sim.events if event.name == "fault"]
    assert all(0.0 < draw <= 1.0 for draw in drawn)


def test_a_run_without_faults_is_as_ever():
    """After a fault ends, the motion of a vehicle it did not affect is unchanged to the last bit."""
    sim = Simulator(lake({"kind": "sensor", "sensor": "depth", "at_s": 0.1, "for_s": 0.2}))
    sound = Simulator(lake())
    for each in (sim, sound):
        each.rov.set_effort(surge=0.7, yaw=0.1)
        each.advance(2.0)
    assert sim.rov.pose.world_from_body.tobytes() == sound.rov.pose.world_from_body.tobytes()


def test_a_vehicle_notices_what_it_can_notice():
    watched = {"leak_then": "go_on", "thruster_then": "go_on", "sensor_then": "go_on"}
    sim = bluerov(
        {"kind": "thruster", "thruster": "front_left", "health": 0.5, "at_s": 1.0},
        {"kind": "sensor", "sensor": "depth", "at_s": 1.0},
        {"kind": "leak", "kg_per_s": 0.05, "at_s": 1.0, "kg_max": 0.2},
        failsafe=watched,
    )
    sim.rov.set_effort(surge=0.5)
    sim.advance(1.0)
    assert sim.rov.failsafe.alarms == ()
    sim.advance(6.0)
    assert set(sim.rov.failsafe.alarms) == {
        "thruster front_left does not obey", "sensor depth is silent", "water inside",
    }  # fmt: skip
    assert sim.rov.failsafe.state == "go_on"


def test_a_sound_vehicle_raises_no_alarm():
    watched = {"leak_then": "surface", "thruster_then": "surface", "sensor_then": "surface"}
    sim = bluerov(failsafe=watched)
    for k in range(30):
        sim.rov.set_effort(surge=0.8 * (-1) ** k, yaw=0.3, heave=-0.1)
        sim.advance(1.0)
    assert sim.rov.failsafe.alarms == ()


def test_a_leak_makes_the_vehicle_surface_if_it_still_can():
    sim = Simulator(
        lake({"kind": "leak", "kg_per_s": 0.2, "kg_max": 3.0, "at_s": 1.0}, failsafe={"leak_then": "surface"})
    )
    sim.rov.set_effort(surge=0.3)
    sim.advance(80.0)
    assert sim.rov.failsafe.cause == "leak"
    assert sim.rov.pose.position_world_m[2] == pytest.approx(-0.5, abs=0.3)


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ({"kind": "thruster", "thruster": "x", "at_s": 1.0}, r"faults\[0\]: thruster = 'x': vehicle 'rov' has no thru"),
        ({"kind": "thruster", "at_s": 1.0}, "exactly one of thruster and axis"),
        ({"kind": "leak", "kg_per_s": 0.1}, "exactly one of at_s and rate_per_h"),
        ({"kind": "sensor", "sensor": "dept", "at_s": 1.0}, "did you mean 'depth'"),
        ({"kind": "sensor", "sensor": "imu", "mode": "bias", "bias": 1.0, "at_s": 1.0}, "field = None: must be one of"),
        ({"kind": "sensor", "sensor": "depth", "bias": 1.0, "at_s": 1.0}, "bias must be given for `mode: bias`"),
        ({"kind": "fire", "at_s": 1.0}, "'thruster'"),
        ({"kind": "link", "vehicle": "nobody", "at_s": 1.0}, "vehicle = 'nobody'"),
    ],
)
def test_mistakes_are_met_at_the_door(fault, message):
    with pytest.raises((ScenarioError, ValueError), match=message):
        Simulator(lake(fault))


def test_a_refused_injection_changes_nothing():
    sim = Simulator(lake())
    with pytest.raises(ValueError, match="sensor = 'sonr'"):
        sim.faults.inject("sensor", sensor="sonr")
    with pytest.raises(ValueError, match="must be one of none"):
        sim.faults.end("sensor")
    assert sim.faults.active == ()
    assert len(sim.events) == 0


LEAST = {
    "sensor": {"sensor": "depth"}, "sonar": {}, "camera": {"camera": "front"}, "battery": {"thrust": 0.5},
    "leak": {"kg_per_s": 0.05}, "link": {}, "current": {"velocity_world_m_s": (0.0, 0.2, 0.0)},
}  # fmt: skip


def test_each_kind_can_be_injected():
    assert {*LEAST, "thruster", "tether"} == set(FAULTS.models())
    for model, thruster in (("rov", {"axis": "yaw"}), ("bluerov2_heavy", {"thruster": "front_left"})):
        sim = Simulator(deep_lake(model=model))
        offered = {"thruster": thruster, **LEAST}
        if not sim.scenario.vehicles[0].model.cameras:
            del offered["camera"]
        for kind, given in offered.items():
            sim.faults.inject(kind, **given)
        assert sim.faults.active == tuple(offered)


def test_the_guide_lists_each_kind():
    guide = (Path(__file__).parents[3] / "docs/guides/faults.md").read_text()
    table = guide.partition("| kind |")[2].partition("\n\n")[0]
    assert re.findall(r"^\| `(\w+)`", table, re.MULTILINE) == list(FAULTS.models())
