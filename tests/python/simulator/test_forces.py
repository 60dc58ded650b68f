"""Forces are visible, and what pushes from outside, a command or the wind, is as stated."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from channel_tools import table
from sites import flat, lake, rov
from uwsim import Simulator
from uwsim.channels import Table
from uwsim.scenario import ScenarioError, load
from uwsim.scenario.build.wind import LEAST_HZ, MOST_HZ, gusts
from uwsim.scenario.spec.water_parts import Wind


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


def npd(f: float, speed: float) -> float:
    """Return ISO 19901-1's density [m2/s2/Hz] 10 m above the water."""
    return 320 * (speed / 10) ** 2 / (1 + (172 * f * (speed / 10) ** -0.75) ** 0.468) ** (5 / (3 * 0.468))


def davenport(f: float, speed: float) -> float:
    x = 1200 * f / speed
    return 4 * 0.0015 * speed**2 * x**2 / (1 + x**2) ** (4 / 3) / f


@pytest.mark.parametrize(("name", "spectrum", "speed"), [("npd", npd, 18.0), ("davenport", davenport, 6.0)])
def test_gusts_have_the_spectrum_of_their_name(name: str, spectrum, speed: float) -> None:
    """That of the series which the harmonics sum to, not of their amplitudes."""
    seeds, total, bands = 20, [], []
    time = np.arange(0.0, 6000.0, 0.8)
    for seed in range(seeds):
        amplitude, omega, phase = gusts(Wind(speed_m_s=speed, gusts=name), seed).T
        series = np.cos(np.outer(time, omega) + phase) @ amplitude
        total.append(series.var())
        density = 2 * 0.8 / len(time) * np.abs(np.fft.rfft(series)) ** 2
        frequency = np.fft.rfftfreq(len(time), 0.8)
        edges = np.geomspace(0.003, 0.3, 6)
        within = [(frequency >= low) & (frequency < high) for low, high in pairwise(edges)]
        bands.append([density[one].sum() * frequency[1] for one in within])
    expected = quad(spectrum, LEAST_HZ, MOST_HZ, args=(speed,), limit=200)[0]
    assert np.mean(total) == pytest.approx(expected, rel=0.03)
    for measured, low, high in zip(np.mean(bands, axis=0), edges[:-1], edges[1:], strict=True):
        assert measured == pytest.approx(quad(spectrum, low, high, args=(speed,))[0], rel=0.06)


@pytest.mark.parametrize("speed", [4.0, 9.0])
def test_a_drifting_boat_goes_before_the_wind_as_its_drag_allows(speed: float) -> None:
    """Windage in surge is the drag ahead: 1/2 rho_a c A (w - u)^2 = 77.55 u."""
    wind = {"speed_m_s": speed, "heading_deg": 0.0}
    sim = Simulator(lake("otter", wind=wind), seed=1)
    sim.advance(60.0)
    u = float(sim.rov.velocity.linear_body_m_s[0])
    air = speed * (0.15 / 10) ** (1 / 7)
    assert 0.5 * 1.225 * 0.7 * 0.17 * (air - u) ** 2 == pytest.approx(77.55 * u, rel=0.02)


def test_without_windage_no_wind_is_felt() -> None:
    still, windy = (
        Simulator(lake("rov", **change), seed=1) for change in ({}, {"wind": {"speed_m_s": 20.0, "gusts": "npd"}})
    )
    for sim in (still, windy):
        sim.advance(5.0)
    assert np.array_equal(still.rov.pose.world_from_body, windy.rov.pose.world_from_body)


def test_optics_and_link_have_the_wind_unless_they_have_their_own() -> None:
    wind, link = {"speed_m_s": 9.0}, {"modem": "s2cm_hs"}
    common = lake("otter", wind=wind, link=link)
    assert common.link.wind_m_s == common.optics.wind_m_s == 9.0
    assert lake("otter", wind=wind, link=link | {"wind_m_s": 2.0}).link.wind_m_s == 2.0
    assert load("lake").wind is None


def test_windage_of_a_hull_that_sinks_is_refused() -> None:
    sail = {"frontal_area_m2": 1.0, "lateral_area_m2": 1.0, "length_m": 1.0, "height_m": 1.0}
    model = {"builds_on": "otter", "mass_kg": 300.0, "coefficients": None, "windage": sail}
    scenario = lake(model)
    with pytest.raises(ValueError, match="windage: is only for a hull that floats"):
        Simulator(scenario)
