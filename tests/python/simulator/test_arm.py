"""A vehicle's arm: it moves, reacts, is read, commanded, saved, repeated and batched; what cannot be is refused."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from channel_tools import table
from sites import flat, rov
from uwsim import Batch, Simulator
from uwsim.channels.ros import build
from uwsim.live import LiveSimulator
from uwsim.scenario import Scenario, ScenarioError
from uwsim.scenario.spec.vehicle import load_vehicle

ARM = "bluerov2_heavy_alpha5"
JOINTS = ("shoulder", "upperarm", "forearm", "wrist")


def site(model: Any = ARM, **changes: object) -> Scenario:
    return flat(rov(model), bed_m=-15.0, **changes)


def with_arm(**changes: Any) -> dict[str, Any]:
    """Return a vehicle that builds on the packaged one, with another arm: a link of one hinge."""
    hinge = {"motor": {"strongest_nm": 2.0, "fastest_deg_s": 60}, "limits_deg": [-90, 90]}
    link = {"mass_kg": 1.0, "inertia_kg_m2": [0.01, 0.01, 0.01], "hinge": hinge, "centre_of_mass_m": [0.2, 0, 0]}
    return {"builds_on": "bluerov2_heavy", "arm": {"boom": link | changes}}


def test_it_reaches_what_it_is_told_and_its_vehicle_tilts() -> None:
    sim = Simulator(site())
    arm = sim.rov.arm
    assert arm.names == arm.motors == JOINTS
    sim.advance(20.0)
    before = sim.rov.pose.world_from_body
    arm.set_joints(positions={"shoulder": 0.5, "upperarm": 1.5})
    sim.advance(8.0)
    now = arm.read()
    assert now.positions == pytest.approx([0.5, 1.5, 0.0, 0.0], abs=1e-3)
    assert now.speeds == pytest.approx(0.0, abs=1e-3)
    assert 0.1 < np.abs(now.motor_torques).max() < 9.0  # the wet weight of what it lifts
    assert np.isnan(now.currents_a).all()
    assert np.degrees(np.arccos(before[:, 2] @ sim.rov.pose.world_from_body[:, 2])) > 2.0
    arm.set_joints(speeds={"shoulder": -0.2})
    sim.advance(1.0)
    assert arm.read().speeds[0] == pytest.approx(-0.2)


def test_its_reaction_is_among_the_forces_and_turns_the_vehicle_against_it() -> None:
    sim = Simulator(site())
    sim.rov.set_joints(speeds={"shoulder": 0.5})
    sim.advance(0.1)
    forces = sim.rov.forces
    parts = sum(forces[name].force_body_n for name in forces if name != "total")
    assert forces["total"].force_body_n == pytest.approx(parts)
    assert np.linalg.norm(forces["arm"].force_body_n) > 1.0
    sim.advance(0.4)
    assert sim.rov.velocity.angular_body_rad_s[2] < -1e-3


def test_commands_beyond_what_it_can_do_change_nothing() -> None:
    sim = Simulator(site())
    before = sim.save_state()
    for bad in (
        {"positions": {"shoulder": 0.1, "upperarm": -0.5}},  # beyond a stop
        {"speeds": {"shoulder": 2.0}},
        {"torques": {"wrist": 6.0}},
        {"positions": {"jaw": 0.1}},  # fixed
        {"positions": {"elbow": 0.1}},
        {"positions": {"wrist": 0.1}, "speeds": {"wrist": 0.1}},
        {"positions": {"wrist": float("nan")}},
    ):
        with pytest.raises(ValueError, match=r"joint|positions|speeds|torques"):
            sim.rov.set_joints(**bad)
    assert sim.save_state() == before
    with pytest.raises(ValueError, match="has no arm"):
        Simulator(site("bluerov2_heavy")).rov.set_joints(positions={"wrist": 0.1})


def test_all_stop_stops_it_where_it_is() -> None:
    sim = Simulator(site())
    sim.rov.set_joints(positions={"upperarm": 2.0})
    sim.advance(1.0)
    sim.rov.all_stop()
    sim.advance(0.1)
    at = sim.rov.arm.read().positions
    sim.advance(2.0)
    assert sim.rov.arm.read().positions == pytest.approx(at, abs=1e-9)
    with pytest.raises(ValueError, match="all stop"):
        sim.rov.set_joints(positions={"wrist": 0.1})


def test_topics_read_and_command_it() -> None:
    sim = Simulator(site())
    channels = table(sim)
    message = build.message("sensor_msgs/msg/JointState", name=["wrist"], position=np.array([0.4]))
    with LiveSimulator(sim, paused=True, speed="max") as live:
        channels["cmd_joints"].apply(live, message)
        live.step(400)
        read = channels["joint_states"].read(sim)
    joints = dict(zip(read.name, read.position, strict=True))
    assert joints["wrist"] == pytest.approx(0.4, abs=0.01)
    assert len(read.velocity) == len(read.effort) == len(read.name)


def test_a_member_of_a_batch_equals_a_simulator() -> None:
    batch, sims = Batch(site(), n=2, seeds=[0, 5]), [Simulator(site(), seed=seed) for seed in (0, 5)]
    batch.set_joints(speeds={"shoulder": [0.2, -0.1]})
    batch.step(200)
    for member, sim in enumerate(sims):
        sim.rov.set_joints(speeds={"shoulder": [0.2, -0.1][member]})
        sim.step(200)
        assert batch.save_state(member) == sim.save_state()
    assert batch.aboard(1).rov.arm.read().speeds[0] == pytest.approx(-0.1)


@pytest.mark.parametrize(
    ("change", "rule"),
    [
        ({"on": "mast"}, "no such link"),
        ({"on": "boom"}, "circle"),
        ({"mass_kg": 0.0}, r"must be in \[0.001"),
        ({"hinge": {"limits_deg": [10, -10]}}, "lower limit must come first"),
        ({"hinge": {"start_deg": 20, "limits_deg": [-10, 10]}}, "must be within limits_deg"),
        ({"hinge": {"axis": [0, 0, 0]}}, "must have a direction"),
        ({"hinge": {"viscous_nm_s_rad": 1e5}}, "2.5 times the inertia"),
        ({"inertia_kg_m2": [1.0, 0.1, 0.1]}, "triangle"),
        ({"slide": {}}, "must not be given beside hinge"),
    ],
)
def test_arms_that_cannot_be_are_refused(change: dict[str, Any], rule: str, tmp_path: Path) -> None:
    path = tmp_path / "vehicle.yaml"
    path.write_text(json.dumps({"name": "v"} | with_arm(**change)))
    with pytest.raises((ScenarioError, ValueError), match=rule):
        Simulator(site(str(path)))


def test_the_packaged_arm_is_level_at_its_start() -> None:
    assert list(load_vehicle(ARM).arm or {}) == ["armbase", *JOINTS, "jaw"]
    sim = Simulator(site())
    sim.advance(8.0)
    level = sim.rov.pose.world_from_body[2, 2]
    assert np.degrees(np.arccos(min(1.0, level))) < 3.0  # in fresh water
    assert abs(sim.rov.velocity.linear_body_m_s[2]) < 0.1


def test_bullets_engine_refuses_it() -> None:
    with pytest.raises((ScenarioError, ValueError), match="must be uwsim for an arm"):
        Simulator(site(dynamics={"engine": "bullet"}))
