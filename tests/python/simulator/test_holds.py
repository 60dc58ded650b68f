"""Holds keep what was measured where the stick was let go, and state what they do when an instrument is lost."""

from __future__ import annotations

import math

import numpy as np
import pytest

from steered import bay
from uwsim import Simulator
from uwsim.base.commands import HOLDS
from uwsim.channels.ros.own_types import TELEMETRY
from uwsim.channels.table import Table
from uwsim.link.packing.panels import pack_telemetry, unpack_telemetry

PLACE = [-4.0, 0.0, -2.5]


def afloat(**holds: bool) -> Simulator:
    """A vehicle in the pool, with these holds, whose estimate has settled."""
    sim = Simulator("pool", seed=3)
    sim.rov.place(PLACE)
    _ = sim.rov.estimate
    sim.advance(1.0)
    if holds:
        sim.rov.command("hold", **holds)
    return sim


def yaw_deg(sim: Simulator) -> float:
    return math.degrees(sim.rov.estimate.pose.yaw_rad)


def test_a_turn_stops_by_itself_where_the_stick_is_let_go() -> None:
    sims = {held: afloat(heading=held) for held in (True, False)}
    for sim in sims.values():
        sim.rov.set_effort(yaw=0.5)
        sim.advance(2.0)
    let_go_deg = yaw_deg(sims[True])
    assert sims[True].rov.holds.targets == {"heading": None}
    assert sims[True].rov.effort[5] == 0.5, "the stick has its own way"
    for sim in sims.values():
        sim.rov.set_effort()
        sim.advance(4.0)
    ((target_rad,),) = sims[True].rov.holds.targets.values()
    assert let_go_deg < math.degrees(target_rad) < let_go_deg + 8.0, "captured when the turn had decayed, not before"
    assert yaw_deg(sims[True]) == pytest.approx(math.degrees(target_rad), abs=1.0)
    assert yaw_deg(sims[False]) > let_go_deg + 12.0, "without the hold it coasts on"


def test_depth_position_and_heading_are_kept_against_a_push_while_other_axes_obey_the_stick() -> None:
    sim = afloat(depth=True, heading=True)
    sim.advance(1.0)
    sim.rov.set_effort(surge=0.4)
    sim.advance(4.0)
    assert sim.rov.effort[0] == 0.4 and sim.rov.estimate.pose.position_world_m[0] > PLACE[0] + 0.5
    assert sim.rov.estimate.pose.position_world_m[2] == pytest.approx(sim.rov.holds.targets["depth"][0], abs=0.05)
    sim.rov.set_effort()
    sim.rov.command("hold", depth=True, heading=True, position=True)
    sim.advance(6.0)
    (x_m, y_m), now_m = sim.rov.holds.targets["position"], sim.rov.estimate.pose.position_world_m
    assert math.hypot(now_m[0] - x_m, now_m[1] - y_m) < 0.1
    assert np.linalg.norm(sim.rov.velocity.linear_body_m_s) < 0.05


def test_a_hold_is_given_a_target_which_the_stick_takes_over() -> None:
    sim = afloat(depth=True, heading=True)
    sim.rov.command("hold_at", heading_rad=0.8, z_world_m=-2.0)
    sim.advance(12.0)
    assert yaw_deg(sim) == pytest.approx(math.degrees(0.8), abs=2.0)
    assert sim.rov.pose.position_world_m[2] == pytest.approx(-2.0, abs=0.05)
    sim.rov.set_effort(yaw=0.3)
    sim.advance(1.0)
    assert sim.rov.holds.targets == {"heading": None, "depth": [-2.0]}
    with pytest.raises(ValueError, match="hold_at: heading is not held: hold it first"):
        afloat(depth=True).rov.command("hold_at", heading_rad=0.0)


def test_speed_is_kept_as_the_stick_left_it_and_altitude_follows_the_bed() -> None:
    sim = afloat()
    sim.rov.set_effort(surge=0.5)
    sim.advance(3.0)
    sim.rov.set_effort()
    sim.rov.command("hold", speed=True, altitude=True)
    sim.advance(0.1)
    (wanted_m_s,), (altitude_m,) = sim.rov.holds.targets["speed"], sim.rov.holds.targets["altitude"]
    sim.advance(2.5)
    assert wanted_m_s > 0.5
    assert sim.rov.velocity.linear_body_m_s[0] == pytest.approx(wanted_m_s, abs=0.03)
    assert sim.rov.sensors["altitude"].read() == pytest.approx(altitude_m, abs=0.1)
    over_bed_z_m = sim.rov.pose.position_world_m[2]
    sim.advance(2.2)
    assert sim.rov.pose.position_world_m[2] > over_bed_z_m + 0.1, "it climbs over the pool's box"


@pytest.mark.parametrize(
    ("sensor", "held", "left", "note"),
    [
        ("depth", {"depth", "heading"}, {"heading"}, "depth hold ended: the sensor of kind depth has no valid reading"),
        ("altitude", {"altitude"}, {"depth"}, "altitude hold became depth hold: the sensor of kind altitude has no"),
        ("dvl", {"position"}, set(), "position hold ended: the sensor of kind dvl has no valid reading"),
        ("imu", {"heading", "depth"}, set(), "heading, depth hold ended: the IMU is silent"),
    ],
)
def test_a_hold_whose_sensor_is_silent_is_released_after_its_patience(
    sensor: str, held: set[str], left: set[str], note: str
) -> None:
    sim = afloat(**dict.fromkeys(held, True))
    sim.advance(1.0)
    sim.faults.inject("sensor", sensor=sensor, mode="off")
    (patience_s,) = {HOLDS[name].patience_s for name in held if sensor in HOLDS[name].sensors} or {1.0}
    sim.advance(patience_s - 0.2)
    assert set(sim.rov.holds.targets) == held, "it has patience"
    sim.advance(0.6)
    assert set(sim.rov.holds.targets) == left
    assert sim.rov.holds.note.startswith(note)
    assert [event.name for event in sim.events][-1] == "hold_ends"
    sim.advance(0.2)
    let_go = {"depth": 2, "heading": 5, "position": 0}
    assert not any(sim.rov.effort[axis] for name, axis in let_go.items() if name in held - left and "depth" not in left)


def test_what_steers_otherwise_ends_the_holds() -> None:
    for end, why in (
        (lambda sim: sim.rov.all_stop(), "all stop"),
        (lambda sim: sim.rov.set_thrusters({}), "another command steers"),
        (lambda sim: sim.rov.place(PLACE), "the vehicle was placed elsewhere"),
    ):
        sim = afloat(heading=True)
        end(sim)
        sim.advance(0.1)
        assert not sim.rov.holds.has_control and sim.rov.holds.note == f"heading hold ended: {why}"
        assert not sim.rov.effort.any()


def test_what_cannot_be_held_is_refused() -> None:
    sim = Simulator("pool")
    for holds, state, rule in (
        ({"depth": True, "altitude": True}, "", "depth and altitude: only one of them can be held"),
        ({"depth": True}, "docked", "is docked: release it first"),
        ({"depth": True}, "stopped", "all stop is set"),
    ):
        if state == "docked":
            sim.rov.all_stop(False)
        elif state == "stopped":
            sim.rov.all_stop()
        with pytest.raises(ValueError, match=f"vehicle 'rov': hold: .*{rule}"):
            sim.rov.command("hold", **holds)
    sim.rov.all_stop(False)
    sim.rov.undock()
    sim.faults.inject("sensor", sensor="imu", mode="off")
    sim.advance(0.1)
    with pytest.raises(ValueError, match=r"hold: heading: its sensor of kind imu has no valid reading"):
        sim.rov.command("hold", heading=True)
    with pytest.raises(ValueError, match=r"command 'hold': depth = 1: must be True or False"):
        sim.rov.command("hold", depth=1)


def test_telemetry_carries_the_holds_over_a_modem_too() -> None:
    sim = afloat(depth=True, position=True)
    sim.advance(1.0)
    (channel,) = [each for each in Table(sim).channels if each.type == TELEMETRY]
    message = channel.read(sim)
    message.hold_note = "altitude hold became depth hold: no echo"
    after = unpack_telemetry(pack_telemetry(message), channel)
    for found in (message, after):
        assert list(found.holds) == ["depth", "position"] and found.hold_note == message.hold_note
        assert found.hold_targets[0] == pytest.approx(-sim.rov.holds.targets["depth"][0], abs=0.01)
        assert 0.0 <= found.hold_targets[1] < 0.1


def test_the_target_of_a_depth_hold_is_shown_below_the_tide_as_the_gauge_is() -> None:
    tide = {"constituents": [{"constituent": "M2", "amplitude_m": 1.5}]}
    start = {"position_m": [0, 0, -8]}
    sim = Simulator(bay({"name": "rov", "model": "bluerov2_heavy", "start": start}, water={"tide": tide}), seed=3)
    _ = sim.rov.estimate
    sim.advance(1.0)
    sim.rov.command("hold", depth=True)
    sim.advance(8.0)
    (channel,) = [each for each in Table(sim).channels if each.type == TELEMETRY]
    message = channel.read(sim)
    assert abs(message.depth + sim.rov.pose.position_world_m[2]) > 0.5, "no tide: this tests nothing"
    assert message.hold_targets[0] == pytest.approx(message.depth, abs=0.15)
