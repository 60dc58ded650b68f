"""Forces are visible: their sum moves the vehicle, and what pushes it from outside is a command like any other."""

import numpy as np
import pytest

from channel_tools import table
from sites import flat, rov
from uwsim import Simulator
from uwsim.channels import Table
from uwsim.scenario import ScenarioError


def puddle(vehicle: dict | None = None, **changes: object) -> Simulator:
    return Simulator(flat(rov() | (vehicle or {}), bed_m=-20.0, **changes))


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


def test_in_waves_the_total_of_a_floating_vehicle_is_its_change_of_momentum() -> None:
    sim = puddle(water={"surface": {"kind": "airy", "amplitude_m": 0.3, "period_s": 3.0}})
    sim.rov.set_effort(surge=0.5, heave=0.3, yaw=0.2)
    sim.rov.place([0.0, 0.0, 0.0])
    sim.advance(4.0)
    before = sim.rov.velocity
    sim.step()
    after, model = sim.rov.velocity, sim.scenario.vehicles[0].model
    change = (after.linear_body_m_s - before.linear_body_m_s) / sim.scenario.step_s
    turning = (after.angular_body_rad_s - before.angular_body_rad_s) / sim.scenario.step_s
    expected_n = model.mass_kg * (change + np.cross(turning, model.centre_of_mass_m))
    assert abs(sim.rov.pose.position_world_m[2]) < 0.5  # so that the surface cuts it
    assert sim.rov.forces["total"].force_body_n == pytest.approx(expected_n, rel=1e-9, abs=1e-6)


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


def test_a_push_shorter_than_a_step_lasts_a_step() -> None:
    sim = puddle()
    sim.rov.apply_wrench([30.0, 0.0, 0.0], duration_s=0.1 * sim.step_s)
    sim.step()
    assert sim.rov.forces["applied"].force_body_n[0] == pytest.approx(30.0)
    sim.step()
    assert sim.rov.forces["applied"].force_body_n[0] == 0.0


def test_a_channel_has_the_forces_on_request() -> None:
    sim = puddle()
    sim.rov.set_effort(surge=1.0)
    sim.advance(1.0)
    channel = table(sim)["forces"]
    message = channel.read(sim)
    force = message.wrenches[message.names.index("actuators")].force
    assert [force.x, force.y, force.z] == pytest.approx(sim.rov.forces["actuators"].force_body_n)
    assert channel.delivery.on_request
    assert "forces" not in {channel.name for channel in Table(sim, truth=False).channels}, "they are the truth"


def test_forces_are_refused_where_they_cannot_be() -> None:
    with pytest.raises(ScenarioError, match=r"until_s = 1 s: must be after from_s, 2 s"):
        puddle(vehicle={"wrenches": [{"from_s": 2, "until_s": 1}]})
    bullet = puddle(dynamics={"engine": "bullet"})
    bullet.rov.apply_wrench([50.0, 0.0, 0.0])
    bullet.advance(1.0)
    assert bullet.rov.velocity.linear_body_m_s[0] > 0.1
    with pytest.raises(ValueError, match=r"dynamics\.engine = bullet: must be uwsim for forces"):
        _ = bullet.rov.forces
