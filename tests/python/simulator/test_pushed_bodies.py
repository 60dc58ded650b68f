"""Loose bodies are pushed from outside: by Python, by schedule and by ROS; the pushes are commands like any other."""

import json

import numpy as np
import pytest

from sites import rov
from test_loose_bodies import body, site
from uwsim.channels import Table
from uwsim.live import LiveSimulator

BALL = body("sphere", "ball", [0, 0, -5], density_kg_m3=1000.0, drag_coefficient=0.0)
PUSH = {"force_n": [30.0, 0.0, 0.0], "torque_nm": [0.0, 0.0, 0.5]}


def test_a_push_moves_a_body_by_the_mass_and_added_mass_that_its_forces_show() -> None:
    sim = site(BALL)
    ball = sim.objects["ball"]
    ball.apply_wrench(**PUSH, duration_s=1.0)
    sim.step()
    forces, rate_m_s2 = ball.forces, ball.velocity.linear_body_m_s[0] / sim.step_s
    assert forces["applied"].force_body_n.tolist() == pytest.approx(PUSH["force_n"])
    assert forces["applied"].torque_body_nm.tolist() == pytest.approx(PUSH["torque_nm"])
    mass_kg = forces["weight"].force_body_n[2] / -sim.world.water.gravity_m_s2
    assert 30.0 / rate_m_s2 == pytest.approx(
        1.5 * mass_kg, rel=0.02
    )  # a sphere: half of the displaced water moves along
    sim.advance(1.0)
    speed_m_s = float(np.linalg.norm(ball.velocity.linear_body_m_s))
    sim.advance(1.0)
    assert np.linalg.norm(ball.velocity.linear_body_m_s) == pytest.approx(speed_m_s, rel=1e-3), "the push has ended"


def test_a_push_along_the_worlds_axes_keeps_its_direction_while_the_body_turns() -> None:
    sim = site(BALL)
    sim.objects["ball"].apply_wrench([0.0, 0.0, 0.0], [0.0, 0.0, 5.0], duration_s=2.0)
    sim.advance(2.0)
    sim.objects["ball"].apply_wrench([0.0, 20.0, 0.0], axes="world")
    sim.advance(3.0)
    x_m, y_m, _ = sim.objects["ball"].pose.position_world_m
    assert y_m > 1.0 and abs(x_m) < 1e-4


@pytest.mark.parametrize("pushed", ["vehicle", "body"])
def test_a_schedule_pushes_as_commands_do(pushed: str) -> None:
    schedule = {"wrenches": [PUSH | {"from_s": 1, "until_s": 2}]}
    is_body = pushed == "body"
    begun = site(BALL | schedule) if is_body else site(BALL, vehicle=rov(position_m=(-8, 0, -5), **schedule))
    by_hand = site(BALL)
    one, other = (sim.objects["ball"] if is_body else sim.rov for sim in (begun, by_hand))
    start_m = other.pose.position_world_m
    begun.advance(3.0)
    by_hand.advance(1.0)
    other.apply_wrench(**PUSH, duration_s=1.0)
    by_hand.advance(2.0)
    assert one.pose.position_world_m.tolist() == other.pose.position_world_m.tolist()
    assert one.pose.position_world_m[0] - start_m[0] > 0.1


def test_a_body_at_rest_is_woken_by_a_push_that_overcomes_friction_only() -> None:
    sim = site(body("box", "crate", [0, 0, -9.69], density_kg_m3=1500.0, friction=0.5))
    crate = sim.objects["crate"]
    sim.advance(5.0)
    assert not crate.velocity.linear_body_m_s.any(), "at rest on the bed"
    place_m = crate.pose.position_world_m.tolist()
    heavy_n = 500.0 * 0.48 * sim.world.water.gravity_m_s2
    crate.apply_wrench([0.3 * heavy_n, 0.0, 0.0])
    sim.advance(2.0)
    assert crate.pose.position_world_m.tolist() == place_m
    crate.apply_wrench([0.8 * heavy_n, 0.0, 0.0], axes="world")
    sim.advance(2.0)
    assert crate.pose.position_world_m[0] > 0.3


def test_the_service_pushes_and_exists_only_where_there_are_bodies() -> None:
    assert "simulation/push_object" not in {service.name for service in Table(site()).services}
    with LiveSimulator(site(BALL), paused=True) as live:
        (service,) = [each for each in Table(live.simulator).services if each.name == "simulation/push_object"]
        assert service.call(live, {"object": "ball", **PUSH})["success"] is True
        live.step(100)
        assert live.simulator.objects["ball"].velocity.linear_body_m_s[0] > 0.1
        refused = service.call(live, {"object": "bell", **PUSH})
        assert refused == {"success": False, "message": "object = 'bell': must be one of ball"}, json.dumps(refused)


@pytest.mark.parametrize(
    ("arguments", "rule"),
    [
        ({"force_n": [1.0, 0.0]}, r"force_n.shape = \(2,\): expected \(3,\)"),
        ({"force_n": [float("nan"), 0.0, 0.0]}, "must be at most 1e9 N"),
        ({"force_n": [float("inf"), 0.0, 0.0]}, "wrench = inf .*: must be at most 1e9 N"),
        ({"force_n": [1.0, 0.0, 0.0], "axes": "sideways"}, "axes = 'sideways': must be one of body, world"),
        ({"force_n": [1.0, 0.0, 0.0], "duration_s": -1.0}, "duration_s = -1: must not be negative"),
    ],
)
def test_what_cannot_be_is_refused_with_the_reason(arguments: dict, rule: str) -> None:
    sim = site(BALL)
    for pushed in (sim.rov, sim.objects["ball"]):
        with pytest.raises(ValueError, match=rule):
            pushed.apply_wrench(**arguments)
