"""Fixed objects with joints: a link swings, resists and stops by the laws of its joint; its object stays."""

from math import sin, sqrt
from typing import Any

import numpy as np
import pytest
from scipy.special import ellipk

from sites import flat, rov
from uwsim import Batch, Simulator
from uwsim.scenario import Scenario, ScenarioError

WATER_KG_M3, GRAVITY_M_S2 = 1000.0, 9.80665
POST = {"kind": "box", "name": "post", "position_m": [0, 0, -5], "size_m": [0.2, 0.2, 0.2]}
COULOMB_NM, RADIUS_M = 2.0, 0.4


def lever(**hinge: Any) -> dict[str, Any]:
    """Return a link that leads north, and turns about z."""
    return {
        "position_m": [0, 0, 0.15],
        "hinge": {"axis": [0, 0, 1], "limits_deg": [-20, 0], "coulomb_nm": COULOMB_NM} | hinge,
        "mass_kg": 0.5, "centre_of_mass_m": [0, 0.3, 0], "inertia_kg_m2": [0.02, 1e-3, 0.02], "volume_m3": 1e-4,
        "shape": {"kind": "box", "name": "lever", "position_m": [0, 0.3, 0], "size_m": [0.04, 0.6, 0.04]},
    }  # fmt: skip


def post(**links: dict[str, Any]) -> dict[str, Any]:
    return {"shape": POST, "fixed": True, "links": links}


def site(*objects: dict[str, Any], **changes: Any) -> Scenario:
    values = {"water": {"density_kg_m3": WATER_KG_M3}, "objects": list(objects)} | changes
    return flat(rov(position_m=(-8, 0, -5)), **values)


def pushed(share: float) -> Scenario:
    """Return a lever, and a ball that touches it and is pushed at the share of what turns it."""
    ball = {"kind": "sphere", "name": "ball", "position_m": [-0.071, RADIUS_M, -4.85], "radius_m": 0.05}
    push = {"force_n": [share * COULOMB_NM / RADIUS_M, 0, 0], "axes": "world"}
    loose = {"shape": ball, "density_kg_m3": WATER_KG_M3, "friction": 0.0, "wrenches": [push]}
    return site(post(handle=lever()), loose)


@pytest.mark.parametrize("start_deg", [10.0, 120.0])
def test_a_link_swings_with_the_period_of_a_physical_pendulum(start_deg: float) -> None:
    """T = 4 K(sin^2(a/2)) sqrt(I / (m g l - rho g V b)), with SciPy's complete elliptic integral K."""
    mass_kg, volume_m3, arm_m, lift_m = 3.0, 1e-3, 0.4, 0.25
    bob = {
        "hinge": {"axis": [0, 1, 0], "start_deg": start_deg},
        "mass_kg": mass_kg, "centre_of_mass_m": [0, 0, -arm_m], "inertia_kg_m2": [0.05, 0.05, 0.05],
        "volume_m3": volume_m3, "centre_of_buoyancy_m": [0, 0, -lift_m],
    }  # fmt: skip
    about_hinge = 0.05 + mass_kg * arm_m**2
    moment_nm = GRAVITY_M_S2 * (mass_kg * arm_m - WATER_KG_M3 * volume_m3 * lift_m)
    period_s = 4 * ellipk(sin(np.radians(start_deg) / 2) ** 2) * sqrt(about_hinge / moment_nm)
    with Simulator(site(post(bob=bob))) as sim:
        joints = sim.objects["post"].joints
        assert joints is not None
        before = sim.objects["post"].pose.world_from_body
        angles = []
        for _ in range(round(2.2 * period_s / sim.step_s)):
            sim.step()
            angles.append(joints.read().positions[0])
        q = np.array(angles)
        at = np.flatnonzero((q[:-1] > 0) & (q[1:] <= 0))
        crossings = at + q[at] / (q[at] - q[at + 1])
        assert np.diff(crossings)[0] * sim.step_s == pytest.approx(period_s, rel=1e-3)
        assert np.radians(start_deg) == pytest.approx(q.max(), rel=1e-3), "no energy is lost or gained"
        assert (sim.objects["post"].pose.world_from_body == before).all()


def test_a_push_turns_a_lever_once_its_moment_exceeds_the_friction_and_the_stop_holds_it() -> None:
    with Simulator(pushed(0.95)) as sim:
        sim.advance(1.0)
        assert abs(sim.objects["post"].joints.read().positions[0]) < 1e-3  # type: ignore[union-attr]
        touched = [contact for contact in sim.objects["post"].contacts if contact.other == "ball"]
        assert {(each.link, each.other_link) for each in touched} == {("handle", "")}
        moment_nm = sum(contact.force_world_n[0] * contact.point_world_m[1] for contact in touched)
        assert moment_nm == pytest.approx(0.95 * COULOMB_NM, rel=0.02)
        assert label_above(sim, (0.0, 0.5)) == "post lever"
    with Simulator(pushed(1.05)) as sim:
        sim.advance(2.0)
        turned = sim.objects["post"].joints.read().positions[0]  # type: ignore[union-attr]
        assert turned == pytest.approx(np.radians(-20.0), abs=1e-3), "clockwise, seen from above"
        assert label_above(sim, (0.0, 0.5)) == "terrain"
        assert label_above(sim, (0.5 * -sin(turned), 0.5 * np.cos(turned))) == "post lever"


def label_above(sim: Simulator, place: tuple[float, float]) -> str:
    """Return what a ray down meets first, from 4 m deep."""
    hit = sim._core.scene_around(0).cast(np.array([[*place, -4.0]]), np.array([[0.0, 0.0, -1.0]]), 50.0)
    return str(sim.label_names[hit.labels[0]])


def test_a_vehicle_is_stopped_by_a_fixed_body_which_stays() -> None:
    wall = {"shape": {"kind": "box", "name": "wall", "position_m": [-6, 0, -5], "size_m": [0.4, 3, 3]}, "fixed": True}
    with Simulator(site(wall)) as sim:
        before = sim.objects["wall"].pose.world_from_body
        sim.rov.set_effort(surge=0.3)
        sim.advance(10.0)
        assert sim.rov.pose.position_world_m[0] < -6.2
        assert {contact.other for contact in sim.rov.contacts} == {"wall"}
        assert (sim.objects["wall"].pose.world_from_body == before).all()
        assert sim.objects["wall"].joints is None


def test_a_batch_reads_joints_and_bodies() -> None:
    scenario = pushed(1.3)
    with Simulator(scenario) as sim:
        sim.advance(2.0)
        assert sim.objects["post"].joints.read().positions[0] < -0.01  # type: ignore[union-attr]
        batch = Batch(scenario, n=2, threads=1)
        batch.step(round(2.0 / sim.step_s))
        inside = batch.aboard(1).objects["post"].joints
        assert (inside.read().positions == sim.objects["post"].joints.read().positions).all()  # type: ignore[union-attr]
        assert (batch.read_joints("post").positions[1] == inside.read().positions).all()
        ball = sim.objects["ball"]
        assert (batch.observe_object("ball").position_world_m[1] == ball.pose.position_world_m).all()
        with pytest.raises(ValueError, match=r"body = 'rov': must be one of post"):
            batch.read_joints()
        with pytest.raises(ValueError, match=r"object = 'bal': must be one of post, ball; did you mean 'ball'"):
            batch.observe_object("bal")


@pytest.mark.parametrize(
    ("wrong", "rule"),
    [
        ({"shape": POST, "mass_kg": 5.0, "links": {"a": lever()}}, r"objects\[0\].links: .*not fixed"),
        ({"shape": POST, "fixed": True, "mass_kg": 5.0}, r"objects\[0\].mass_kg = 5.*a body that is fixed"),
        (
            {"shape": POST, "fixed": True, "path": {"points_m": [[1, 0, -5]], "speed_m_s": 1}},
            r"objects\[0\].path.*a body that is fixed",
        ),
        (post(a=lever(motor={"strongest_nm": 1, "fastest_deg_s": 9})), r"links.a.hinge.motor: .*nothing commands it"),
        (post(a=lever() | {"on": "b"}), r"objects\[0\].links.a.on = 'b': no such link"),
        (post(a=lever() | {"on": "b"}, b=lever() | {"on": "a", "shape": None}), r"hold each other in a circle"),
        (post(a=lever(), b=lever()), r"links.a.shape.name = 'lever': must be unique"),
    ],
)
def test_what_a_fixed_body_cannot_have_is_refused(wrong: dict[str, Any], rule: str) -> None:
    with pytest.raises(ScenarioError, match=rule):
        site(wrong)
