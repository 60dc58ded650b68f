"""Loose bodies: laws of what floats, sinks, rests and is pushed; instruments perceive them; all state is kept."""

from math import pi, sqrt, tanh

import numpy as np
import pytest

from sites import flat, rov
from uwsim import Simulator
from uwsim.scenario import ScenarioError

WATER_KG_M3, BED_M = 1000.0, -10.0


def body(kind: str, name: str, position_m: list[float], *, on_bed: bool = False, **values: object) -> dict:
    sizes = {"size_m": values.pop("size_m", [1.0, 0.8, 0.6])} if kind == "box" else {"radius_m": values.pop("r", 0.2)}
    shape = {"kind": kind, "name": name, "position_m": position_m, "on_bed": on_bed, **sizes}
    return {"shape": shape, **values}


def site(*objects: dict, vehicle: dict | None = None, **changes: object) -> Simulator:
    values = {"water": {"density_kg_m3": WATER_KG_M3}, "objects": list(objects)} | changes
    return Simulator(flat(vehicle or rov(position_m=(-8, 0, -5)), bed_m=BED_M, **values))


def gravity(sim: Simulator) -> float:
    return sim.world.water.gravity_m_s2


def test_a_floating_box_has_the_draft_and_the_period_of_the_closed_form() -> None:
    """Archimedes; and T = 2 pi sqrt((m + s a33) / (rho g A)), where the added mass counts by the submerged share s."""
    share, up_m = 0.5, 0.01
    draft_m = share * 0.6
    light = {"density_kg_m3": 500.0, "drag_coefficient": 0.0}
    sim = site(body("box", "raft", [0, 0, 0.3 - draft_m + up_m], **light), body("box", "deep", [9, 0, -5], **light))
    rising = sim.objects["deep"].forces  # from rest, and wholly in the water
    mass_kg = rising["weight"].force_body_n[2] / -gravity(sim)
    added_kg = -mass_kg * rising["added_mass"].force_body_n[2] / rising["total"].force_body_n[2]
    assert mass_kg == pytest.approx(500.0 * 0.48, rel=1e-6)
    heights = []
    for _ in range(1200):
        sim.step()
        heights.append(float(sim.objects["raft"].pose.position_world_m[2]) - (0.3 - draft_m))
    z = np.array(heights)
    before = np.flatnonzero((z[:-1] < 0) & (z[1:] >= 0))
    crossings = before + z[before] / (z[before] - z[before + 1])
    period_s = np.diff(crossings).mean() * sim.step_s
    assert abs(z.mean()) < 0.1 * up_m
    expected_s = 2 * pi * sqrt((mass_kg + share * added_kg) / (WATER_KG_M3 * gravity(sim) * 0.8))
    assert period_s == pytest.approx(expected_s, rel=2e-3)


def test_a_sphere_sinks_at_its_terminal_velocity() -> None:
    """At v = sqrt(8 (s - 1) g r / (3 C)) drag equals weight less buoyancy; from rest, by v tanh(a t / v); straight."""
    sim = site(body("sphere", "ball", [0, 0, -1], density_kg_m3=1500.0, drag_coefficient=0.47))
    sim.advance(2.5)
    final_m_s = sqrt(8 * 0.5 * gravity(sim) * 0.2 / (3 * 0.47))
    first_m_s2 = 0.5 * gravity(sim) / (1.5 + 0.5)
    expected_m_s = final_m_s * tanh(first_m_s2 * 2.5 / final_m_s)
    assert sim.objects["ball"].velocity.linear_body_m_s[2] == pytest.approx(-expected_m_s, rel=3e-3)
    assert np.abs(sim.objects["ball"].pose.position_world_m[:2]).max() < 1e-9


@pytest.mark.parametrize(("radius_m", "density_kg_m3"), [(0.01, 1100.0), (0.05, 1020.0), (0.1, 1050.0), (0.05, 900.0)])
def test_a_ball_without_a_stated_drag_sinks_as_measured_ones(radius_m: float, density_kg_m3: float) -> None:
    """Brown and Lawler 2003, "Sphere drag and settling velocity revisited", J. Environ. Eng. 129:222: 480 balls."""
    sim = site(body("sphere", "ball", [0, 0, -5], r=radius_m, density_kg_m3=density_kg_m3))
    sim.advance(6.0)
    number = 2 * radius_m * (speed_m_s := abs(sim.objects["ball"].velocity.linear_body_m_s[2])) / 1.2e-6
    drag = 24 / number * (1 + 0.15 * number**0.681) + 0.407 / (1 + 8710 / number)
    net = abs(density_kg_m3 / WATER_KG_M3 - 1)
    assert speed_m_s == pytest.approx(sqrt(8 * net * gravity(sim) * radius_m / (3 * drag)), rel=0.04)
    fast = site(body("sphere", "ball", [0, 0, -5], density_kg_m3=1200.0, velocity_m_s=[0, 0, -3])).objects["ball"]
    share = fast.forces["drag"].force_body_n[2] / (0.5 * WATER_KG_M3 * pi * 0.2**2 * 3.0**2)
    assert 0.06 < share < 0.2, "Achenbach 1972: turbulent from 4e5 on"


def test_added_mass_of_a_sphere_is_half_of_the_water_it_displaces() -> None:
    sim = site(body("sphere", "ball", [0, 0, -5], density_kg_m3=1500.0))
    forces = sim.objects["ball"].forces  # from rest: (m + a) nu' = (m - rho V) g
    volume_m3 = 4 / 3 * pi * 0.2**3
    fall_m_s2 = -forces["total"].force_body_n[2] / (1500.0 * volume_m3)
    assert fall_m_s2 == pytest.approx(gravity(sim) * 0.5 / (1.5 + 0.5), rel=0.01)


def test_boxes_that_rest_on_each_other_stay() -> None:
    crates = [
        body("box", f"crate{k}", [0.1 * k, 0.05 * k, BED_M + 0.31 + 0.605 * k], density_kg_m3=1800.0) for k in range(3)
    ]
    sim = site(*crates)
    sim.advance(15.0)
    before = [crate.pose.position_world_m for crate in sim.objects.values()]
    assert [point[2] for point in before] == pytest.approx([BED_M + 0.3 + 0.6 * k for k in range(3)], abs=0.01)
    sim.advance(15.0)
    for crate, then in zip(sim.objects.values(), before, strict=True):
        assert np.abs(crate.pose.position_world_m - then).max() < 3e-5
    under = sum(contact.force_world_n[2] for contact in sim.objects["crate0"].contacts if contact.other == "")
    assert under == pytest.approx(3 * 800.0 * 0.48 * gravity(sim), rel=0.02), "the bed carries all three"


def test_a_push_conserves_momentum() -> None:
    """Equal bodies, each with the water it carries along, on the line through both middles; restitution 0.2."""
    still = {"density_kg_m3": 1000.0, "drag_coefficient": 0.0, "restitution": 0.2}
    sim = site(
        body("box", "hammer", [0, 0, -5], **still, velocity_m_s=[0.5, 0, 0]), body("box", "nail", [1.3, 0, -5], **still)
    )
    sim.advance(3.0)
    speeds = [sim.objects[name].velocity.linear_body_m_s[0] for name in ("hammer", "nail")]
    assert speeds == pytest.approx([0.2, 0.3], rel=1e-3)


def test_parameters_are_those_without_objects() -> None:
    assert list(site(body("box", "crate", [0, 0, -5], density_kg_m3=1400.0)).parameters) == list(site().parameters)


def test_instruments_perceive_loose_bodies_where_they_are() -> None:
    sim = site(
        body("box", "wall", [-5, 0, -5], density_kg_m3=1000.0, size_m=[1, 4, 4], drag_coefficient=10.0),
        vehicle=rov("rov", (-10, 0, -5)),
    )
    ping = sim.rov.sonar.ping()
    label = sim.label_names.index("wall")
    assert label in ping.labels[ping.valid]
    hits = ping.points_sonar_m[ping.labels == label].astype(float)
    on_wall = hits @ ping.world_from_sonar[:3, :3].T + ping.world_from_sonar[:3, 3]
    assert on_wall[:, 0] == pytest.approx(-5.5, abs=0.001), "its face"
    frame = sim.rov.cameras["front"].capture()
    assert "wall" in {frame.label_names[k] for k in np.unique(frame.labels)}
    assert "wall" in sim.strengths_db and "wall" in sim.materials


@pytest.mark.parametrize(
    ("wrong", "rule"),
    [
        (body("box", "rov", [0, 0, -2], density_kg_m3=1.0), r"objects\[0\].shape.name = 'rov': is already in use"),
        (body("box", "crate", [0, 0, -2]), "give one of density_kg_m3 and mass_kg"),
        (body("box", "crate", [0, 0, -2], density_kg_m3=900.0, mass_kg=3.0), "give one of density_kg_m3 and mass_kg"),
        (body("box", "crate", [0, 0, -20], mass_kg=3.0), "must be above the bed"),
        (
            {"shape": {"kind": "pipeline", "name": "pipe", "points_m": [[0, 0], [5, 0]], "radius_m": 1}, "mass_kg": 3},
            "must be one of box, cylinder, mesh, sphere",
        ),
    ],
)
def test_what_cannot_be_is_refused_with_the_reason(wrong: dict, rule: str) -> None:
    with pytest.raises(ScenarioError, match=rule):
        site(wrong)


def test_scattered_bodies_have_their_density_keep_apart_and_depend_on_their_own_seed() -> None:
    def scattered(own_seed: int, **changes: object) -> dict[str, np.ndarray]:
        spread = {"per_100_m2": 6, "area_m": [30, 20], "seed": own_seed}
        crate = body("box", "crate", [5, -3, 0], on_bed=True, density_kg_m3=1500.0, scatter=spread)
        sim = site(crate, body("sphere", "ball", [0, 20, 0], density_kg_m3=500.0), **changes)
        assert [*sim.objects][-1] == "ball"
        return {name: each.pose.position_world_m for name, each in sim.objects.items() if name != "ball"}

    one = scattered(1)
    assert list(one) == [f"crate_{number}" for number in range(1, 37)]  # 6 per 100 m2 of 600 m2
    xy_m = np.array([position_m[:2] for position_m in one.values()])
    assert (abs(xy_m - [5, -3]) <= [15, 10]).all()
    assert (np.ptp(xy_m, axis=0) > [24, 16]).all(), "they fill the area"
    assert min(np.linalg.norm(a - b) for k, a in enumerate(xy_m) for b in xy_m[:k]) > np.hypot(1.0, 0.8)
    for other, is_same in ((scattered(1, seed=7), True), (scattered(2), False)):
        assert np.array_equal([*one.values()], [*other.values()]) is is_same


@pytest.mark.parametrize(
    ("changes", "rule"),
    [
        ({"per_100_m2": 0.01}, "gives 0 bodies"),
        ({"per_100_m2": 40}, "gives 240 bodies: must be at least 1, and at most 200"),
        ({"per_100_m2": 30, "apart_m": 4}, "leaves no room for 180 bodies"),
    ],
)
def test_bodies_that_cannot_be_scattered_are_refused(changes: dict, rule: str) -> None:
    spread = {"area_m": [30, 20]} | changes
    with pytest.raises(ScenarioError, match=rf"objects\[0\]\.scatter: {rule}"):
        site(body("box", "crate", [5, -3, 0], on_bed=True, density_kg_m3=1500.0, scatter=spread))
