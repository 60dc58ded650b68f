"""Forces are visible: their sum moves the vehicle, and what pushes it from outside is a command like any other."""

from pathlib import Path

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.channels import Table
from uwsim.live import LiveSimulator, replay
from uwsim.recording import Recorder
from uwsim.recording.replay import replay as replay_recording
from uwsim.scenario import Scenario, ScenarioError
from uwsim.scenario.read.validated import validated

PUDDLE = {
    "name": "puddle",
    "terrain": {"source": "noise", "size_m": [40, 40], "spacing_m": 1, "bed_depth_m": 20, "hill_height_m": 0},
    "vehicles": [{"name": "rov", "model": "bluerov2_heavy", "start": {"position_m": [0, 0, -5]}}],
}


def puddle(**changes: object) -> Simulator:
    entry = PUDDLE["vehicles"][0] | changes.pop("vehicle", {})
    return Simulator(validated(Scenario, PUDDLE | {"vehicles": [entry]} | changes))


def test_the_terms_sum_to_the_total_and_each_is_what_its_name_says() -> None:
    sim = puddle()
    sim.rov.set_effort(surge=0.5)
    sim.advance(20.0)
    forces, model = sim.rov.forces, sim.scenario.vehicles[0].model
    sum_n = sum(wrench.force_body_n for name, wrench in forces.items() if name != "total")
    assert forces["total"].force_body_n == pytest.approx(sum_n, abs=1e-9)
    weight_n = sim.rov.pose.world_from_body[:3, :3] @ forces["weight"].force_body_n
    assert weight_n == pytest.approx([0, 0, -model.mass_kg * sim.world.water.gravity_m_s2], rel=1e-9, abs=1e-9)
    thrust_n, drag_n = forces["actuators"].force_body_n[0], forces["drag"].force_body_n[0]
    assert thrust_n > 10 and drag_n == pytest.approx(-thrust_n, rel=0.05)  # at its final speed
    assert not forces["applied"].force_body_n.any() and not forces["contact"].force_body_n.any()


def test_contacts_carry_what_the_water_does_not() -> None:
    sim = puddle(vehicle={"trim": {"net_buoyancy_n": -60.0}})
    sim.rov.place([0.0, 0.0, -19.7])
    sim.advance(10.0)
    assert not sim.rov.velocity.linear_body_m_s.any(), "at rest on the bed"
    pushes = np.array([contact.force_world_n for contact in sim.rov.contacts])
    assert {contact.other for contact in sim.rov.contacts} == {""}
    forces = sim.rov.forces
    sinks_n = -(forces["weight"].force_body_n + forces["buoyancy"].force_body_n)
    assert pushes.sum(axis=0)[2] == pytest.approx(np.linalg.norm(sinks_n), rel=0.01)
    assert np.abs(forces["total"].force_body_n).max() < 1e-9


def test_a_push_is_recorded_and_replayed(tmp_path: Path) -> None:
    with LiveSimulator(puddle(), paused=True, speed="max") as live:
        with Recorder(live, tmp_path / "run.mcap", topics=["forces", "force_arrows"]):
            live.step(10)
            live.rov.apply_wrench([30.0, 0.0, 0.0], axes="world", duration_s=0.5)
            live.step(200)
            assert live.rov.velocity.linear_body_m_s[0] > 0.1
        state, tick = live.simulator.save_state(), live.tick
    assert replay(puddle(), live.log, tick).save_state() == state
    found = replay_recording(tmp_path / "run.mcap")
    assert found.difference is None and found.state_compared and found.commands == 1


def test_a_schedule_pushes_as_commands_do() -> None:
    pushed = puddle(vehicle={"wrenches": [{"force_n": [30, 0, 0], "torque_nm": [0, 0, 2], "from_s": 1, "until_s": 2}]})
    by_hand = puddle()
    pushed.advance(3.0)
    by_hand.advance(1.0)
    by_hand.rov.apply_wrench([30.0, 0.0, 0.0], [0.0, 0.0, 2.0], duration_s=1.0)
    by_hand.advance(2.0)
    assert pushed.rov.pose.position_world_m.tolist() == by_hand.rov.pose.position_world_m.tolist()
    assert pushed.rov.pose.position_world_m[0] > 0.1


def test_a_push_shorter_than_a_step_lasts_a_step() -> None:
    sim = puddle()
    sim.rov.apply_wrench([30.0, 0.0, 0.0], duration_s=0.1 * sim.step_s)
    sim.step()
    assert sim.rov.forces["applied"].force_body_n[0] == pytest.approx(30.0)
    sim.step()
    assert sim.rov.forces["applied"].force_body_n[0] == 0.0


def test_arrows_show_the_forces_to_scale() -> None:
    sim = puddle()
    sim.rov.set_effort(surge=1.0)
    sim.advance(1.0)
    channels = {channel.name: channel for channel in Table(sim).channels}
    message, arrows = channels["forces"].read(sim), channels["force_arrows"].read(sim).markers
    longest_n = max(np.linalg.norm([each.force.x, each.force.y, each.force.z]) for each in message.wrenches)
    (thrust,) = [arrow.points[1] for arrow in arrows if arrow.ns == "actuators"]
    force = message.wrenches[message.names.index("actuators")].force
    assert [thrust.x, thrust.y, thrust.z] == pytest.approx(np.array([force.x, force.y, force.z]) / longest_n)
    assert all(channels[name].delivery.on_request for name in ("forces", "force_arrows"))
    assert "forces" not in {channel.name for channel in Table(sim, truth=False).channels}, "they are the truth"


def test_what_cannot_be_is_refused_with_the_reason() -> None:
    sim = puddle()
    for arguments, rule in (
        ({"force_n": [1.0, 0.0]}, r"force_n.shape = \(2,\): expected \(3,\)"),
        ({"force_n": [float("nan"), 0.0, 0.0]}, "must be at most 1e9 N"),
        ({"force_n": [1.0, 0.0, 0.0], "axes": "sideways"}, "axes = 'sideways': must be one of body, world"),
        ({"force_n": [1.0, 0.0, 0.0], "duration_s": -1.0}, "duration_s = -1: must not be negative"),
    ):
        with pytest.raises(ValueError, match=rule):
            sim.rov.apply_wrench(**arguments)
    with pytest.raises(ScenarioError, match=r"until_s = 1 s: must be after from_s, 2 s"):
        puddle(vehicle={"wrenches": [{"from_s": 2, "until_s": 1}]})
    bullet = puddle(dynamics={"engine": "bullet"})
    bullet.rov.apply_wrench([50.0, 0.0, 0.0])
    bullet.advance(1.0)
    assert bullet.rov.velocity.linear_body_m_s[0] > 0.1
    with pytest.raises(ValueError, match=r"dynamics\.engine = bullet: must be uwsim for forces"):
        _ = bullet.rov.forces
